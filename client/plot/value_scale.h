// From numbers to places along an axis or a legend, with round marks.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tessera::client {

enum class ScaleKind { kLinear, kLogarithmic };

struct ValueRange {
  double low = 0, high = 1;
};

/// Values from `low` to `high`, which is larger; both positive where it is logarithmic.
struct ValueScale {
  ScaleKind kind = ScaleKind::kLinear;
  double low = 0, high = 1;

  /// 0 at low, 1 at high, and beyond them outside. NaN for NaN; values that have no logarithm are at -1.
  double place(double value) const;
  /// The value at a place.
  double value(double place) const;
};

/// A scale with round ends over all finite values but the largest of a share of `cut` of them, of logarithmic
/// ones the smallest, too. Linear ones begin at 0 unless values are negative or all close to each other;
/// logarithmic ones have six decades at most. `range` takes the place of both ends. Values that no scale
/// fits, such as none, give 0 to 1 (of logarithms 0.1 to 1).
ValueScale scale_over(std::span<const double> values, ScaleKind kind,
                      const std::optional<ValueRange>& range = {}, double cut = 0);

struct ScaleTick {
  double value = 0;
  std::string label;
};

/// Round values within the scale, ascending: multiples of 1, 2 or 5 times a power of ten, about `wanted` of
/// them and at least two; of logarithmic scales of more than a decade powers of ten, with 2 and 5 times those
/// where there is room.
std::vector<ScaleTick> ticks_on(const ValueScale& scale, int wanted = 6);

/// The shortest text of a number that is round to multiples of `step`: "0.25", "12 000" with a narrow
/// no-break space, "2·10⁶".
std::string tick_label(double value, double step);

}  // namespace tessera::client
