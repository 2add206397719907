// The table of sigmoids that is built into the program.
#pragma once

namespace tessera::spectra {

/// Measured, in CIEDE2000 over sRGB and its faces: differences of up to 0.45 with 24, 0.33 with 28.
inline constexpr int kOwnResolution = 28;
inline constexpr int kOwnRowFloats = 4 * 3 * kOwnResolution * kOwnResolution * kOwnResolution;

/// The rows that fit_table(kOwnResolution) returns, as write_table.cpp wrote it when the program was built:
/// pages of the program's file, which are read when they are looked up.
extern const float kOwnRows[kOwnRowFloats];

}  // namespace tessera::spectra
