// Figures as text: as many digits as their errors let them have.
#pragma once

#include <string>
#include <string_view>

#include "measure/measured.h"

namespace tessera::client {

struct ConfidenceInterval {
  double low = 0, high = 0;
};

/// The 95 % interval of a figure by Student's t; of an exact one its value twice.
ConfidenceInterval confidence_95(const Figure& figure);

/// Whether the figure has no error: a closed form.
bool is_exact(const Figure& figure);

struct FigureText {
  std::string value;
  std::string error;  // of the same decimals; empty where there is none
};

/// The error with two significant digits, or one where the first is 3 or more, and the value to the same
/// decimal: "512.3" and "0.8". Numbers from 10^7 on and below 10^-4 have powers of ten, "5.123e-06" and
/// "8e-09". A value without an error has six digits.
FigureText figure_text(double value, double error);

/// "512.3 +- 0.8", "(5.123 +- 0.008)e-06"; alone where there is no error.
std::string with_error(double value, double error);

/// The shortest text that reads as the same number; "nan", "inf".
std::string shortest_text(double value);

/// Six significant digits at most.
std::string short_text(double value);

/// "11", "5 (night)": the value of a step, with a word where no daylight is there.
std::string step_text(const MeasuredStep& step);

}  // namespace tessera::client
