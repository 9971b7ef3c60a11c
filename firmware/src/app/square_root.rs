//! The square root that interrupts take.

/// Root of a number, correctly rounded as IEEE 754 has it, so the same bits wherever it is computed; NaN of a negative one.
///
/// On the processor it is one instruction of 14 cycles (Arm's *Cortex-M4 Technical Reference Manual*, 7.2.3), where `libm`
/// takes some hundred.
///
/// ```
/// use firmware::app::square_root::square_root;
///
/// assert_eq!(square_root(2.0), 1.414_213_5);
/// ```
#[inline]
pub fn square_root(number: f32) -> f32 {
    #[cfg(target_arch = "arm")]
    return instruction(number);
    #[cfg(not(target_arch = "arm"))]
    libm::sqrtf(number)
}

/// The compiler lets assembly among Rust take a floating-point register only where there are double ones too. By the
/// hard-float calling convention argument and result are in S0.
#[cfg(target_arch = "arm")]
#[unsafe(naked)]
extern "C" fn instruction(number: f32) -> f32 {
    core::arch::naked_asm!(".fpu fpv4-sp-d16", "vsqrt.f32 s0, s0", "bx lr")
}
