#include "photometry/sky/cie_sky.h"

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace tessera::photometry {
namespace {

struct CieRow {
  double a, b, c, d, e;
  const char* name;
};

// Table 1 of the standard; the same in [Darula2002].
constexpr CieRow kCieRows[kCieSkies] = {
    {4, -0.7, 0, -1, 0, "CIE standard overcast sky, steep luminance gradation towards zenith"},
    {4, -0.7, 2, -1.5, 0.15,
     "overcast, with steep luminance gradation and slight brightening towards the sun"},
    {1.1, -0.8, 0, -1, 0, "overcast, moderately graded with azimuthal uniformity"},
    {1.1, -0.8, 2, -1.5, 0.15, "overcast, moderately graded and slight brightening towards the sun"},
    {0, -1, 0, -1, 0, "sky of uniform luminance"},
    {0, -1, 2, -1.5, 0.15,
     "partly cloudy sky, no gradation towards zenith, slight brightening towards the sun"},
    {0, -1, 5, -2.5, 0.3, "partly cloudy sky, no gradation towards zenith, brighter circumsolar region"},
    {0, -1, 10, -3, 0.45, "partly cloudy sky, no gradation towards zenith, distinct solar corona"},
    {-1, -0.55, 2, -1.5, 0.15, "partly cloudy, with the obscured sun"},
    {-1, -0.55, 5, -2.5, 0.3, "partly cloudy, with brighter circumsolar region"},
    {-1, -0.55, 10, -3, 0.45, "white-blue sky with distinct solar corona"},
    {-1, -0.32, 10, -3, 0.45, "CIE standard clear sky, low luminance turbidity"},
    {-1, -0.32, 16, -3, 0.3, "CIE standard clear sky, polluted atmosphere"},
    {-1, -0.15, 16, -3, 0.3, "cloudless turbid sky with broad solar corona"},
    {-1, -0.15, 24, -2.8, 0.15, "white-blue turbid sky with broad solar corona"},
};

}  // namespace

absl::StatusOr<SkyPattern> cie_pattern(int type) {
  if (type == kTraditionalOvercast) return SkyPattern{.traditional_overcast = true};
  if (type < 1 || type > kCieSkies) {
    return absl::InvalidArgumentError(absl::StrCat("there is no CIE sky of type ", type,
                                                   "; types are 1 to 15, and 16: traditional overcast"));
  }
  const CieRow& row = kCieRows[type - 1];
  return SkyPattern{.a = row.a,
                    .b = row.b,
                    .c = row.c,
                    .d = row.d,
                    .e = row.e,
                    .k = std::exp(row.d * std::numbers::pi / 2)};
}

const char* cie_sky_name(int type) {
  if (type == kTraditionalOvercast) return "traditional overcast sky";
  return type < 1 || type > kCieSkies ? "" : kCieRows[type - 1].name;
}

}  // namespace tessera::photometry
