// Spellings of units and numbers.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tessera::photometry {

/// A symbol of a product, and its power.
struct UnitFactor {
  std::string symbol;
  int power = 1;
};

/// The factors of "W/(m2 sr)", "W m^-2 sr^-1", "W·m⁻²·sr⁻¹", "lm per m2": those behind a slash or "per" have
/// negative powers, up to the end or the parenthesis. Nothing for what is no product.
std::optional<std::vector<UnitFactor>> factors_of(std::string_view text);

/// ASCII letters alone.
std::string lower(std::string_view text);
std::string_view without_blanks(std::string_view text);
/// The whole text as a number in C's notation, whatever the locale.
std::optional<double> whole_number(std::string_view text);
/// The shortest text that is read back as the same number.
std::string shortest(double value);

}  // namespace tessera::photometry
