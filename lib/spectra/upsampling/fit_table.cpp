#include "spectra/upsampling/fit_table.h"

#include <algorithm>
#include <cstddef>

#include "spectra/upsampling/fit.h"
#include "spectra/upsampling/table.h"

namespace tessera::spectra {
namespace {

/// Where an entry is: the largest component, its level, and the ratios of the two after it.
struct Place {
  std::size_t largest, level, next, after_next;
};

class TableFit {
 public:
  explicit TableFit(int resolution) : nodes_(resolution), resolution_(static_cast<std::size_t>(resolution)) {
    rows_.resize(4 * 3 * resolution_ * resolution_ * resolution_);
  }

  std::vector<float> run() {
    for (std::size_t largest = 0; largest < 3; ++largest) {
      for (std::size_t next = 0; next < resolution_; ++next) {
        for (std::size_t after_next = 0; after_next < resolution_; ++after_next)
          fit_levels({largest, 0, next, after_next});
      }
    }
    return std::move(rows_);
  }

 private:
  Triple fit(const Place& place, const Triple& start) {
    // White has an infinite coefficient; with this one it is darker by 1e-4.
    constexpr double kWhite = 50;
    const double level = nodes_.levels[place.level];
    Triple rgb, found;
    rgb[place.largest] = level;
    rgb[(place.largest + 1) % 3] = level * nodes_.ratios[place.next];
    rgb[(place.largest + 2) % 3] = level * nodes_.ratios[place.after_next];
    if (rgb[0] == rgb[1] && rgb[1] == rgb[2]) {
      found = {0, 0, std::min(inverse_sigmoid(level), kWhite)};
    } else {
      found = fit_sigmoid(rgb, start).coefficients;
    }
    const std::size_t index =
        ((place.largest * resolution_ + place.level) * resolution_ + place.next) * resolution_ +
        place.after_next;
    for (std::size_t c = 0; c < 3; ++c) rows_[4 * index + c] = static_cast<float>(found[c]);
    return found;
  }

  void fit_levels(Place place) {
    // From the middle to black and to white: each fit starts where the one before ended.
    const std::size_t middle = resolution_ / 2;
    place.level = middle;
    const Triple at_middle = fit(place, {0, 0, 0});
    Triple last = at_middle;
    for (place.level = middle; place.level-- > 0;) last = fit(place, last);
    last = at_middle;
    for (place.level = middle + 1; place.level < resolution_; ++place.level) last = fit(place, last);
  }

  const SigmoidNodes nodes_;
  const std::size_t resolution_;
  std::vector<float> rows_;
};

}  // namespace

std::vector<float> fit_table(int resolution) { return TableFit(resolution).run(); }

}  // namespace tessera::spectra
