// Fits the sigmoids of a table; the build writes those of the program's own table into it.
#pragma once

#include <vector>

namespace tessera::spectra {

/// Fits resolution^3 sigmoids for each component that may be the largest: with 28, 0.7 s. Returns four floats
/// each, c0, c1, c2 and 0, ordered by the largest component, its level, and the ratios of the next component
/// and of the one after that (SigmoidNodes), the last the fastest. They have the same bits on every machine.
std::vector<float> fit_table(int resolution);

}  // namespace tessera::spectra
