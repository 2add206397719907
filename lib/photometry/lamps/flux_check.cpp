// Figures of photometric files against their intensities.
#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"
#include "photometry/lamps/lamp_file.h"
#include "photometry/lamps/text_lines.h"
#include "photometry/units/spelling.h"

namespace tessera::photometry {
namespace {

// Files round their figures to a few digits, and the programs that wrote them summed zones of some degrees.
constexpr double kTolerance = 0.02;
constexpr double kLeastOutputRatio = 0.2;

bool differ(double a, double b) { return std::abs(a - b) > kTolerance * std::max(std::abs(a), std::abs(b)); }

/// Labels of IES files that tell the flux of the luminaire, such as [TOTALLUMINAIRELUMENS] and [_LUMENS].
void check_labels(const Luminaire& l, double total, std::vector<std::string>& warnings) {
  for (const auto& [key, text] : l.labels) {
    const std::string name = lower(key);
    if (name.find("lumens") == std::string::npos || name.find("lamp") != std::string::npos) continue;
    const std::string_view first = std::string_view(text).substr(0, text.find_first_of(" \n"));
    const auto told = file_number(first);
    if (told && *told > 0 && differ(*told, total))
      warnings.push_back(absl::StrFormat(
          "[%s] says %.6g lm; its intensities make %.6g lm, which is what it emits", key, *told, total));
  }
}

void check_eulumdat(const Luminaire& l, double total, std::vector<std::string>& warnings) {
  const EulumdatFields& fields = l.eulumdat;
  const double lumens = fields.sets.empty() ? 0 : fields.sets.front().lumens;
  const double told = lumens * fields.light_output_ratio_percent / 100;
  if (told > 0 && differ(told, total))
    warnings.push_back(
        absl::StrFormat("it says %.6g lm of lamps at a light output ratio of %.6g %%, %.6g lm; its "
                        "intensities make %.6g lm, which is what it emits",
                        lumens, fields.light_output_ratio_percent, told, total));
  if (!(total > 0)) return;
  const double downward = 100 * downward_flux(l) / total;
  if (fields.downward_flux_percent > 0 &&
      std::abs(downward - fields.downward_flux_percent) > 100 * kTolerance)
    warnings.push_back(
        absl::StrFormat("it says that %.4g %% of its flux goes downward; its intensities send %.4g %%",
                        fields.downward_flux_percent, downward));
}

}  // namespace

std::vector<std::string> flux_warnings(const Luminaire& l) {
  std::vector<std::string> warnings;
  const double total = flux(l);
  if (!(total > 0)) {
    warnings.push_back("it emits no light");
    return warnings;
  }
  check_labels(l, total, warnings);
  if (l.is_eulumdat) {
    check_eulumdat(l, total, warnings);
    return warnings;
  }
  const double lamps = l.lamp_lumens() * l.ballast_factor * l.lamp_ballast_factor;
  if (l.is_absolute() || !(lamps > 0)) return warnings;
  if (total > lamps * (1 + kTolerance / 4)) {
    warnings.push_back(absl::StrFormat(
        "its intensities make %.6g lm, more than the %.6g lm of its lamps; it emits the former", total,
        lamps));
  } else if (total < kLeastOutputRatio * lamps) {
    warnings.push_back(absl::StrFormat(
        "its intensities make %.6g lm, only %.3g %% of the %.6g lm of its lamps; it emits the former", total,
        100 * total / lamps, lamps));
  }
  return warnings;
}

}  // namespace tessera::photometry
