//! Vectors of the processor that this program runs on.
//!
//! The core is built for every x86-64, whose vectors hold four numbers. Loops over lanes are compiled
//! for wider ones too, and what the processor has is chosen when it runs. None of them fuses a product
//! with a sum: the bits are the same in all.

/// Vectors that a processor may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Vectors {
    /// Those that the program is built for.
    Baseline,
    /// Eight numbers.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// Sixteen numbers.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Vectors {
    /// Those that this processor has, the widest last.
    pub fn present() -> Vec<Self> {
        let mut present = vec![Self::Baseline];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") {
                present.push(Self::Avx2);
            }
            let wide = is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512vl");
            let masked =
                is_x86_feature_detected!("avx512dq") && is_x86_feature_detected!("avx512bw");
            if wide && masked {
                present.push(Self::Avx512);
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
            Self::Avx2 => "AVX2",
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => "AVX-512",
        }
    }
}
