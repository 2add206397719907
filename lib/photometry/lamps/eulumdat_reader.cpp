// EULUMDAT files (.ldt) [Stockmar 1990].
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "absl/strings/str_cat.h"
#include "photometry/lamps/lamp_file.h"
#include "photometry/lamps/text_lines.h"
#include "photometry/units/spelling.h"

namespace tessera::photometry {
namespace {

using Lines = std::vector<std::string_view>;

/// Planes whose intensities a file has: the first of them, from 0, and their number.
struct StoredPlanes {
  std::size_t first = 0, count = 1;
};

StoredPlanes stored_planes(int symmetry, std::size_t planes) {
  if (planes == 1 || symmetry == 1) return {0, 1};
  switch (symmetry) {
    case 2:
      return {0, planes / 2 + 1};
    case 3:
      return {3 * planes / 4, planes / 2 + 1};
    case 4:
      return {0, planes / 4 + 1};
    default:
      return {0, planes};
  }
}

class EulumdatReader {
 public:
  EulumdatReader(const Lines& lines, const LampFileOptions& options, std::vector<std::string>& warnings)
      : lines_(lines), options_(options), warnings_(warnings) {}

  absl::StatusOr<Luminaire> read() {
    l_.is_eulumdat = true;
    if (auto s = read_head(); !s.ok()) return s;
    if (auto s = read_body(); !s.ok()) return s;
    if (auto s = read_sets(); !s.ok()) return s;
    for (double& ratio : l_.eulumdat.direct_ratios) {
      if (auto s = number("direct ratio", ratio); !s.ok()) return s;
    }
    if (auto s = read_table(); !s.ok()) return s;
    if (used_comma_) warn("numbers have decimal commas");
    return std::move(l_);
  }

 private:
  void warn(const std::string& what) { warnings_.push_back(note_at(options_.name, line(), what)); }
  absl::Status fault(const std::string& what) const { return fault_at(options_.name, line(), 0, what); }
  /// The latest line that was read, from 1.
  int line() const { return std::max(1, static_cast<int>(next_)); }

  absl::Status text(const char* what, std::string& value) {
    if (next_ == lines_.size()) return fault(absl::StrCat("the file ends where the ", what, " was expected"));
    value = label_text(lines_[next_++]);
    return absl::OkStatus();
  }

  absl::Status label(const char* key, const char* what) {
    std::string value;
    if (auto s = text(what, value); !s.ok()) return s;
    if (!value.empty()) l_.labels.emplace_back(key, value);
    return absl::OkStatus();
  }

  absl::Status parse(const char* what, std::string_view word, double& value) {
    const auto found = file_number(word, true);
    if (!found || !std::isfinite(*found))
      return fault(absl::StrCat("'", label_text(word), "' is no number; the ", what, " was expected"));
    used_comma_ = used_comma_ || word.find(',') != std::string_view::npos;
    value = *found;
    return absl::OkStatus();
  }

  /// A number at the beginning of a line of its own.
  absl::Status number(const char* what, double& value) {
    std::string whole;
    if (auto s = text(what, whole); !s.ok()) return s;
    const std::string_view word = std::string_view(whole).substr(0, whole.find_first_of(" ;"));
    if (word.empty()) {
      warn(absl::StrCat("an empty line where the ", what, " was expected; 0 is taken"));
      value = 0;
      return absl::OkStatus();
    }
    return parse(what, word, value);
  }

  template <class Int>
  absl::Status count(const char* what, double least, double most, Int& value) {
    double found = 0;
    if (auto s = number(what, found); !s.ok()) return s;
    if (!(found >= least && found <= most) || found != std::floor(found))
      return fault(absl::StrCat(shortest(found), " cannot be the ", what, "; ", shortest(least), " to ",
                                shortest(most), " was expected"));
    value = static_cast<Int>(found);
    return absl::OkStatus();
  }

  absl::Status read_head() {
    EulumdatFields& e = l_.eulumdat;
    if (auto s = label("MANUFAC", "company"); !s.ok()) return s;
    if (auto s = count("type of light source", 0, 3, e.type); !s.ok()) return s;
    if (auto s = count("symmetry", 0, 4, e.symmetry); !s.ok()) return s;
    const double most = static_cast<double>(lines_.size());
    if (auto s = count("number of C planes", 1, most, planes_); !s.ok()) return s;
    if (auto s = number("distance of C planes", e.c_step); !s.ok()) return s;
    if (auto s = count("number of intensities in a plane", 2, most, angles_); !s.ok()) return s;
    if (auto s = number("distance of intensities in a plane", e.gamma_step); !s.ok()) return s;
    if (auto s = label("TEST", "number of the report"); !s.ok()) return s;
    if (auto s = label("LUMINAIRE", "name of the luminaire"); !s.ok()) return s;
    if (auto s = label("LUMCAT", "number of the luminaire"); !s.ok()) return s;
    if (auto s = label("_FILENAME", "name of the file"); !s.ok()) return s;
    return label("ISSUEDATE", "date");
  }

  absl::Status read_body() {
    EulumdatFields& e = l_.eulumdat;
    struct Field {
      const char* what;
      double* value;
    };
    const Field fields[] = {{"length of the luminaire", &l_.length},
                            {"width of the luminaire", &l_.width},
                            {"height of the luminaire", &l_.height},
                            {"length of the luminous area", &e.luminous_length},
                            {"width of the luminous area", &e.luminous_width},
                            {"height of the luminous area at C0", &e.luminous_heights[0]},
                            {"height of the luminous area at C90", &e.luminous_heights[1]},
                            {"height of the luminous area at C180", &e.luminous_heights[2]},
                            {"height of the luminous area at C270", &e.luminous_heights[3]},
                            {"downward flux fraction", &e.downward_flux_percent},
                            {"light output ratio", &e.light_output_ratio_percent},
                            {"conversion factor for intensities", &l_.eulumdat_factor},
                            {"tilt of the luminaire", &e.tilt_degrees}};
    for (const Field& field : fields) {
      if (auto s = number(field.what, *field.value); !s.ok()) return s;
    }
    if (l_.eulumdat_factor > 0) return absl::OkStatus();
    warn(absl::StrCat("a conversion factor for intensities of ", shortest(l_.eulumdat_factor),
                      " is read as 1"));
    l_.eulumdat_factor = 1;
    return absl::OkStatus();
  }

  absl::Status read_sets() {
    std::size_t sets = 0;
    if (auto s = count("number of sets of lamps", 1, 20, sets); !s.ok()) return s;
    for (std::size_t i = 0; i < sets; ++i) {
      LampSet set;
      if (auto s = count("number of lamps", -1e6, 1e6, set.count); !s.ok()) return s;
      if (auto s = text("type of lamps", set.type); !s.ok()) return s;
      if (auto s = number("flux of the lamps", set.lumens); !s.ok()) return s;
      if (!(set.lumens >= 0)) return fault("the flux of the lamps is negative");
      if (auto s = text("colour of lamps", set.color); !s.ok()) return s;
      if (auto s = text("colour rendering of lamps", set.rendering); !s.ok()) return s;
      if (auto s = number("power of the lamps", set.watts); !s.ok()) return s;
      l_.eulumdat.sets.push_back(std::move(set));
    }
    const LampSet& first = l_.eulumdat.sets.front();
    l_.lamps = std::max(1, std::abs(first.count));
    // A number of lamps below 0: figures are of the luminaire, not of its lamps.
    l_.lumens_per_lamp = first.count < 0 ? -1 : first.lumens / l_.lamps;
    l_.watts = first.watts;
    if (first.lumens == 0) warn("the flux of its lamps is 0: it emits no light");
    return absl::OkStatus();
  }

  /// Numbers of several lines, one or more on each.
  absl::Status list(const char* what, std::size_t count, std::vector<double>& values) {
    while (values.size() < count) {
      if (next_ == lines_.size())
        return fault(absl::StrCat("the file ends where ", what, " ", values.size() + 1, " of ", count,
                                  " was expected"));
      std::string_view rest = without_blanks(lines_[next_++]);
      while (!rest.empty() && values.size() < count) {
        const std::size_t end = std::min(rest.find_first_of(" \t;"), rest.size());
        double value = 0;
        if (auto s = parse(what, rest.substr(0, end), value); !s.ok()) return s;
        values.push_back(value);
        rest.remove_prefix(end);
        rest = rest.substr(std::min(rest.find_first_not_of(" \t;"), rest.size()));
      }
    }
    return absl::OkStatus();
  }

  absl::Status read_table() {
    EulumdatFields& e = l_.eulumdat;
    if ((e.symmetry == 4 || e.symmetry == 3) && planes_ > 1 && planes_ % 4 != 0)
      return fault(
          absl::StrCat(planes_, " C planes have no symmetry ", e.symmetry, ": a multiple of 4 was expected"));
    if (e.symmetry == 2 && planes_ > 1 && planes_ % 2 != 0)
      return fault(absl::StrCat(planes_, " C planes have no symmetry 2: an even number was expected"));
    if (auto s = list("C angle", planes_, e.c_degrees); !s.ok()) return s;
    if (auto s = list("gamma angle", angles_, l_.polar_degrees); !s.ok()) return s;
    const int line_of_angles = line();
    const StoredPlanes stored = stored_planes(e.symmetry, planes_);
    std::size_t bytes = 0;
    for (std::size_t i = next_; i < lines_.size(); ++i) bytes += lines_[i].size() + 1;
    if (stored.count * angles_ > bytes)
      return fault(absl::StrCat("the file is too short for ", stored.count, " x ", angles_, " intensities"));
    if (auto s = list("intensity", stored.count * angles_, l_.values); !s.ok()) return s;
    const auto negative = std::ranges::count_if(l_.values, [](double v) { return v < 0; });
    if (negative > 0) {
      warn(absl::StrCat(negative, " intensities are negative, and read as 0"));
      for (double& value : l_.values) value = std::max(value, 0.0);
    }
    put_planes(stored);
    std::string what = fault_of(l_);
    if (what.empty()) what = symmetry_fault();
    return what.empty() ? absl::OkStatus() : fault_at(options_.name, line_of_angles, 0, what);
  }

  /// Planes that are the same as others have to go from one plane of symmetry to the next.
  std::string symmetry_fault() const {
    const int symmetry = l_.eulumdat.symmetry;
    if (l_.plane_degrees.size() == 1 || symmetry < 2) return "";
    const double first = symmetry == 3 ? 90 : 0, last = symmetry == 2 ? 180 : symmetry == 3 ? 270 : 90;
    if (l_.plane_degrees.front() == first && l_.plane_degrees.back() == last) return "";
    return absl::StrCat("planes of symmetry ", symmetry, " go from ", shortest(l_.plane_degrees.front()),
                        " to ", shortest(l_.plane_degrees.back()), " degrees; ", shortest(first), " to ",
                        shortest(last), " was expected");
  }

  void put_planes(const StoredPlanes& stored) {
    const std::vector<double>& all = l_.eulumdat.c_degrees;
    if (stored.count == 1) {
      l_.plane_degrees = {0};
      return;
    }
    for (std::size_t i = 0; i < stored.count; ++i) {
      const std::size_t plane = stored.first + i;
      l_.plane_degrees.push_back(plane < all.size() ? all[plane] : all[plane - all.size()] + 360);
    }
    if (l_.eulumdat.symmetry != 3) return;
    // Planes from C270 over C0 to C90, which are those from C90 over C180 to C270 in a mirror.
    std::ranges::reverse(l_.plane_degrees);
    for (double& degrees : l_.plane_degrees) degrees = 540 - degrees;
    std::vector<double> mirrored;
    for (std::size_t i = stored.count; i-- > 0;) {
      const auto row = l_.values.begin() + static_cast<std::ptrdiff_t>(i * angles_);
      mirrored.insert(mirrored.end(), row, row + static_cast<std::ptrdiff_t>(angles_));
    }
    l_.values = std::move(mirrored);
  }

  const Lines& lines_;
  const LampFileOptions& options_;
  std::vector<std::string>& warnings_;
  Luminaire l_;
  std::size_t next_ = 0, planes_ = 1, angles_ = 2;
  bool used_comma_ = false;
};

}  // namespace

absl::StatusOr<Luminaire> read_eulumdat(std::string_view bytes, const LampFileOptions& options,
                                        std::vector<std::string>& warnings) {
  const Lines lines = lines_of(bytes);
  auto luminaire = EulumdatReader(lines, options, warnings).read();
  if (!luminaire.ok()) return luminaire.status();
  for (const std::string& warning : flux_warnings(*luminaire))
    warnings.push_back(absl::StrCat(options.name, ": ", warning));
  return luminaire;
}

}  // namespace tessera::photometry
