// EULUMDAT files.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>

#include "absl/strings/str_cat.h"
#include "photometry/lamps/lamp_file.h"
#include "photometry/units/spelling.h"

namespace tessera::photometry {
namespace {

/// The step of an even list; 0 of others, as the format has it.
double step_of(const std::vector<double>& list) {
  constexpr double kSlack = 1e-6;
  if (list.size() < 2) return 0;
  const double step = list[1] - list[0];
  for (std::size_t i = 2; i < list.size(); ++i) {
    if (std::abs(list[i] - list[i - 1] - step) > kSlack) return 0;
  }
  return step;
}

int symmetry_of(const std::vector<double>& planes) {
  if (planes.size() == 1) return 1;
  if (planes.front() == 0 && planes.back() == 90) return 4;
  if (planes.front() == 0 && planes.back() == 180) return 2;
  if (planes.front() == 90 && planes.back() == 270) return 3;
  return 0;
}

/// All planes of a turn, whose intensities `planes` tell by symmetry.
std::vector<double> whole_turn(const std::vector<double>& planes, int symmetry) {
  std::set<double> all;
  if (symmetry == 1) {
    for (int c = 0; c < 360; c += 15) all.insert(c);
  }
  for (const double c : planes) {
    all.insert(std::fmod(c, 360));
    if (symmetry == 2 || symmetry == 4) all.insert(std::fmod(360 - c, 360));
    if (symmetry == 4) all.insert({180 - c, 180 + c});
    if (symmetry == 3) all.insert(std::fmod(540 - c, 360));
  }
  return {all.begin(), all.end()};
}

/// That light in cd/klm.
Luminaire as_eulumdat(Luminaire l) {
  if (l.is_eulumdat) return l;
  EulumdatFields& e = l.eulumdat;
  e.symmetry = symmetry_of(l.plane_degrees);
  e.type = e.symmetry == 1 ? 1 : 3;
  const double total = flux(l), lamps = l.lamp_lumens();
  const bool absolute = !(lamps > 0);
  const double lumens = absolute ? total : lamps;
  const double scale = lumens > 0 ? l.candelas_per_value() * 1000 / lumens : 0;
  for (double& value : l.values) value *= scale;
  if (e.symmetry == 0 && l.plane_degrees.back() == 360) {
    l.plane_degrees.pop_back();
    l.values.resize(l.plane_degrees.size() * l.polar_degrees.size());
  }
  e.c_degrees = whole_turn(l.plane_degrees, e.symmetry);
  e.c_step = step_of(e.c_degrees), e.gamma_step = step_of(l.polar_degrees);
  LampSet set;
  set.count = absolute ? -std::max(1, l.lamps) : l.lamps;
  set.lumens = lumens, set.watts = l.watts;
  e.sets = {set};
  e.light_output_ratio_percent = absolute || lumens == 0 ? 100 : 100 * total / lumens;
  l.is_eulumdat = true;
  e.downward_flux_percent = total > 0 ? 100 * downward_flux(l) / total : 0;
  // IES files have the length of the opening along C0; EULUMDAT along C90.
  const double millimetres = l.feet ? 304.8 : 1000;
  e.luminous_length = std::abs(l.width) * millimetres;
  e.luminous_width = l.width < 0 ? 0 : std::abs(l.length) * millimetres;
  for (double& height : e.luminous_heights) height = l.height * millimetres;
  l.length = e.luminous_length, l.width = e.luminous_width, l.height = e.luminous_heights[0];
  return l;
}

class LineWriter {
 public:
  void line(double value) { line(shortest(value)); }
  void line(const std::string& value) { absl::StrAppend(&text_, value, "\r\n"); }
  void line(const std::vector<double>& values) {
    for (const double value : values) line(value);
  }
  /// The first line of a label.
  void label(const Luminaire& l, std::string_view key) {
    const auto found = std::ranges::find_if(l.labels, [&](const auto& one) { return one.first == key; });
    line(found == l.labels.end() ? std::string() : found->second.substr(0, found->second.find('\n')));
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

/// Rows of intensities in the order of the file.
void write_values(const Luminaire& l, LineWriter& out) {
  const std::size_t planes = l.plane_degrees.size(), angles = l.polar_degrees.size();
  const bool mirrored = l.eulumdat.symmetry == 3 && planes > 1;
  for (std::size_t i = 0; i < planes; ++i) {
    const std::size_t plane = mirrored ? planes - 1 - i : i;
    for (std::size_t k = 0; k < angles; ++k) out.line(l.values[plane * angles + k]);
  }
}

}  // namespace

absl::StatusOr<std::string> write_eulumdat(const Luminaire& luminaire) {
  if (const std::string fault = fault_of(luminaire); !fault.empty()) return absl::InvalidArgumentError(fault);
  if (luminaire.system != PlaneSystem::kC)
    return absl::InvalidArgumentError(
        "EULUMDAT has C planes alone; A and B planes can be written as IES files");
  const Luminaire l = as_eulumdat(luminaire);
  const EulumdatFields& e = l.eulumdat;
  LineWriter out;
  out.label(l, "MANUFAC");
  out.line(e.type);
  out.line(e.symmetry);
  out.line(static_cast<double>(e.c_degrees.size()));
  out.line(e.c_step);
  out.line(static_cast<double>(l.polar_degrees.size()));
  out.line(e.gamma_step);
  for (const char* key : {"TEST", "LUMINAIRE", "LUMCAT", "_FILENAME", "ISSUEDATE"}) out.label(l, key);
  for (const double value : {l.length, l.width, l.height, e.luminous_length, e.luminous_width})
    out.line(value);
  for (const double value : e.luminous_heights) out.line(value);
  for (const double value :
       {e.downward_flux_percent, e.light_output_ratio_percent, l.eulumdat_factor, e.tilt_degrees})
    out.line(value);
  out.line(static_cast<double>(e.sets.size()));
  for (const LampSet& set : e.sets) {
    out.line(set.count);
    out.line(set.type);
    out.line(set.lumens);
    out.line(set.color);
    out.line(set.rendering);
    out.line(set.watts);
  }
  for (const double ratio : e.direct_ratios) out.line(ratio);
  out.line(e.c_degrees);
  out.line(l.polar_degrees);
  write_values(l, out);
  return out.take();
}

}  // namespace tessera::photometry
