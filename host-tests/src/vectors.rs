//! Vectors of the processor that this program runs on.
//!
//! The core is built for every x86-64, whose vectors hold four numbers. Loops over lanes are compiled
//! for wider ones too, and what the processor has is chosen when it runs. None of them fuses a product
//! with a sum: the bits are the same in all.

/// That a processor has been asked: made in this file alone.
#[cfg(target_arch = "x86_64")]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Detected(());

/// Vectors that this processor has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Vectors {
    /// Those that the program is built for.
    Baseline,
    /// Eight numbers.
    #[cfg(target_arch = "x86_64")]
    Avx2(Detected),
    /// Sixteen numbers.
    #[cfg(target_arch = "x86_64")]
    Avx512(Detected),
}

impl Vectors {
    /// Those that this processor has, the widest last.
    pub fn present() -> Vec<Self> {
        let mut present = vec![Self::Baseline];
        #[cfg(target_arch = "x86_64")]
        {
            let wider = is_x86_feature_detected!("avx2");
            if wider {
                present.push(Self::Avx2(Detected(())));
            }
            let wide = is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512vl");
            let masked =
                is_x86_feature_detected!("avx512dq") && is_x86_feature_detected!("avx512bw");
            // The compiler takes AVX-512 to mean these too.
            let implied = is_x86_feature_detected!("fma") && is_x86_feature_detected!("f16c");
            if wider && wide && masked && implied {
                present.push(Self::Avx512(Detected(())));
            }
        }
        present
    }

    /// The widest that this processor has.
    pub fn widest() -> Self {
        Self::present().pop().unwrap_or(Self::Baseline)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Baseline => "of the build's baseline",
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(_) => "AVX2",
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(_) => "AVX-512",
        }
    }
}
