// IES LM-63 of 1986, 1991, 1995, 2002 and 2019.
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

/// The text behind "TILT=", or nothing.
std::optional<std::string_view> tilt_of(std::string_view line) {
  line = without_blanks(line);
  if (lower(line.substr(0, 4)) != "tilt") return std::nullopt;
  const std::string_view rest = without_blanks(line.substr(4));
  if (!rest.starts_with('=')) return std::nullopt;
  return without_blanks(rest.substr(1));
}

/// The year of a first line such as "IESNA:LM-63-2002"; 1986 for files without.
int year_of(std::string_view first) {
  const std::string small = lower(without_blanks(first));
  if (!small.starts_with("iesna") && !small.starts_with("ies:")) return 1986;
  for (const int year : {2019, 2002, 1995}) {
    if (first.find(absl::StrCat("LM-63-", year)) != std::string_view::npos) return year;
  }
  return 1991;
}

class IesReader {
 public:
  IesReader(const Lines& lines, const LampFileOptions& options, std::vector<std::string>& warnings)
      : lines_(lines), options_(options), warnings_(warnings) {}

  absl::StatusOr<Luminaire> read() {
    if (auto s = read_head(); !s.ok()) return s;
    WordReader words(lines_, head_end_);
    if (auto s = read_tilt(words); !s.ok()) return s;
    if (auto s = read_numbers(words); !s.ok()) return s;
    if (auto s = read_table(words); !s.ok()) return s;
    if (words.used_comma()) warn(words.line(), "commas stand between numbers");
    if (!words.next().empty()) warn(words.line(), "what follows the last intensity is not read");
    return std::move(l_);
  }

 private:
  void warn(int line, const std::string& what) { warnings_.push_back(note_at(options_.name, line, what)); }
  absl::Status fault(int line, int column, const std::string& what) const {
    return fault_at(options_.name, line, column, what);
  }

  absl::Status read_head() {
    std::size_t line = 0;
    if (lines_.empty()) return fault(1, 0, "the file is empty");
    l_.ies_year = year_of(lines_[0]);
    if (l_.ies_year != 1986) {
      ++line;
      if (l_.ies_year == 1991 && lower(lines_[0]).find("91") == std::string::npos)
        warn(1, absl::StrCat("'", label_text(lines_[0]),
                             "' names no version of LM-63; it is read as that of 1991"));
    }
    for (; line < lines_.size(); ++line) {
      if (const auto tilt = tilt_of(lines_[line])) {
        tilt_ = *tilt, head_end_ = line + 1;
        return absl::OkStatus();
      }
      read_label(lines_[line], static_cast<int>(line) + 1);
    }
    return fault(static_cast<int>(lines_.size()), 0, "there is no line TILT=");
  }

  void read_label(std::string_view text, int line) {
    const std::string whole = label_text(text);
    if (!whole.starts_with('[')) {
      if (whole.empty()) return;
      if (l_.ies_year > 1986) warn(line, "a line without a keyword");
      l_.labels.emplace_back("", whole);
      return;
    }
    const std::size_t end = whole.find(']');
    if (end == std::string::npos) {
      warn(line, "a keyword without ']'");
      l_.labels.emplace_back("", whole);
      return;
    }
    const std::string key = whole.substr(1, end - 1), value(without_blanks(whole.substr(end + 1)));
    if (key == "MORE" && !l_.labels.empty()) {
      absl::StrAppend(&l_.labels.back().second, "\n", value);
    } else {
      if (key == "MORE") warn(line, "[MORE] continues no line");
      l_.labels.emplace_back(key, value);
    }
  }

  absl::Status read_tilt(WordReader& words) {
    const std::string kind = lower(tilt_);
    if (kind == "none") return absl::OkStatus();
    if (kind == "include") return read_tilt_table(words, options_.name);
    l_.tilt.file = label_text(tilt_);
    const int line = static_cast<int>(head_end_);
    if (l_.tilt.file.empty()) return fault(line, 0, "TILT= names no file; NONE or INCLUDE was expected");
    if (options_.tilt_files == nullptr) {
      warn(line, absl::StrCat("'", l_.tilt.file,
                              "', which TILT= names, is not read: the lamp's tilt does nothing"));
      return absl::OkStatus();
    }
    const auto text = options_.tilt_files(l_.tilt.file);
    if (!text.ok()) {
      warn(line, absl::StrCat("'", l_.tilt.file,
                              "', which TILT= names, cannot be read: the lamp's tilt does nothing"));
      return absl::OkStatus();
    }
    const Lines other_lines = lines_of(*text);
    WordReader others(other_lines, 0);
    return read_tilt_table(others, l_.tilt.file);
  }

  absl::Status read_tilt_table(WordReader& words, const std::string& file) {
    double geometry = 0, count = 0;
    if (auto s = number(words, "geometry of lamp and luminaire", geometry, file); !s.ok()) return s;
    if (auto s = number(words, "number of tilt angles", count, file); !s.ok()) return s;
    l_.tilt.geometry = geometry >= 1 && geometry <= 3 ? static_cast<int>(geometry) : 1;
    if (geometry != l_.tilt.geometry)
      warnings_.push_back(
          note_at(file, words.line(), "a geometry of the lamp other than 1, 2 and 3 is read as 1"));
    if (!(count >= 1 && count <= static_cast<double>(words.bytes_left())) || count != std::floor(count))
      return fault_at(file, words.line(), words.column(),
                      absl::StrCat(shortest(count), " is no number of tilt angles"));
    if (auto s = list(words, "tilt angle", static_cast<std::size_t>(count), l_.tilt.degrees, file); !s.ok())
      return s;
    return list(words, "tilt factor", static_cast<std::size_t>(count), l_.tilt.factors, file);
  }

  absl::Status number(WordReader& words, const char* what, double& value, const std::string& file) const {
    const std::string_view word = words.next();
    if (word.empty())
      return fault_at(file, words.line(), 0, absl::StrCat("the file ends where the ", what, " was expected"));
    const auto found = file_number(word);
    if (!found || !std::isfinite(*found))
      return fault_at(file, words.line(), words.column(),
                      absl::StrCat("'", label_text(word), "' is no number; the ", what, " was expected"));
    value = *found;
    return absl::OkStatus();
  }

  absl::Status list(WordReader& words, const char* what, std::size_t count, std::vector<double>& values,
                    const std::string& file) const {
    values.clear();
    for (std::size_t i = 0; i < count; ++i) {
      double value = 0;
      const std::string each = absl::StrCat(what, " ", i + 1, " of ", count);
      if (auto s = number(words, each.c_str(), value, file); !s.ok()) return s;
      values.push_back(value);
    }
    return absl::OkStatus();
  }

  /// A whole number from `least` on.
  absl::Status count(WordReader& words, const char* what, double least, double& value) const {
    if (auto s = number(words, what, value, options_.name); !s.ok()) return s;
    if (value >= least && value == std::floor(value) && value < 1e9) return absl::OkStatus();
    return fault(words.line(), words.column(), absl::StrCat(shortest(value), " cannot be the ", what));
  }

  absl::Status read_numbers(WordReader& words) {
    double lamps = 0, system = 0, unit = 0, other_factor = 1;
    const auto real = [&](const char* what, double& value) {
      return number(words, what, value, options_.name);
    };
    if (auto s = count(words, "number of lamps", 0, lamps); !s.ok()) return s;
    if (auto s = real("lumens per lamp", l_.lumens_per_lamp); !s.ok()) return s;
    if (auto s = real("candela multiplier", l_.multiplier); !s.ok()) return s;
    if (!(l_.multiplier > 0))
      return fault(words.line(), words.column(),
                   absl::StrCat("a candela multiplier of ", shortest(l_.multiplier), " is not above 0"));
    if (auto s = count(words, "number of vertical angles", 1, vertical_); !s.ok()) return s;
    if (auto s = count(words, "number of horizontal angles", 1, horizontal_); !s.ok()) return s;
    if (auto s = count(words, "photometric type (1: C, 2: B, 3: A)", 1, system); !s.ok()) return s;
    if (system > 3)
      return fault(
          words.line(), words.column(),
          absl::StrCat("there is no photometric type ", shortest(system), "; 1 (C), 2 (B) and 3 (A) are"));
    l_.system = system == 1 ? PlaneSystem::kC : system == 2 ? PlaneSystem::kB : PlaneSystem::kA;
    if (auto s = count(words, "units type (1: feet, 2: metres)", 0, unit); !s.ok()) return s;
    if (unit != 1 && unit != 2)
      warn(words.line(), absl::StrCat("units type ", shortest(unit),
                                      " is neither feet (1) nor metres (2); metres are taken"));
    l_.feet = unit == 1;
    if (auto s = real("width of the luminous opening", l_.width); !s.ok()) return s;
    if (auto s = real("length of the luminous opening", l_.length); !s.ok()) return s;
    if (auto s = real("height of the luminous opening", l_.height); !s.ok()) return s;
    if (auto s = real("ballast factor", l_.ballast_factor); !s.ok()) return s;
    if (!(l_.ballast_factor > 0)) {
      warn(words.line(), absl::StrCat("a ballast factor of ", shortest(l_.ballast_factor), " is read as 1"));
      l_.ballast_factor = 1;
    }
    if (auto s = real("factor behind the ballast factor", other_factor); !s.ok()) return s;
    if (l_.ies_year == 2019) {
      l_.file_generation = other_factor;
    } else if (l_.ies_year <= 1995 && other_factor > 0) {
      l_.lamp_ballast_factor = other_factor;
    } else if (other_factor != 1) {
      warn(words.line(), absl::StrCat("the factor behind the ballast factor is ", shortest(other_factor),
                                      ", and read as 1"));
    }
    if (auto s = real("input watts", l_.watts); !s.ok()) return s;
    l_.lamps = static_cast<int>(lamps);
    if (l_.lumens_per_lamp < 0 && l_.lumens_per_lamp != -1)
      warn(words.line(), absl::StrCat(shortest(l_.lumens_per_lamp),
                                      " lumens per lamp are read as -1: absolute photometry"));
    if (l_.lumens_per_lamp < 0) l_.lumens_per_lamp = -1;
    return absl::OkStatus();
  }

  absl::Status read_table(WordReader& words) {
    // Each value takes a digit and what parts it from the next.
    if (vertical_ * horizontal_ > static_cast<double>(words.bytes_left()))
      return fault(words.line(), words.column(),
                   absl::StrCat("the file is too short for ", shortest(vertical_), " x ",
                                shortest(horizontal_), " intensities"));
    std::vector<double> vertical, horizontal;
    if (auto s = list(words, "vertical angle", static_cast<std::size_t>(vertical_), vertical, options_.name);
        !s.ok())
      return s;
    if (auto s =
            list(words, "horizontal angle", static_cast<std::size_t>(horizontal_), horizontal, options_.name);
        !s.ok())
      return s;
    const int line_of_angles = words.line();
    if (l_.system == PlaneSystem::kC && horizontal.size() == 1 && horizontal[0] != 0) {
      warn(line_of_angles,
           absl::StrCat("the only plane is at ", shortest(horizontal[0]), " degrees; it is taken for all"));
      horizontal[0] = 0;
    }
    std::vector<double> values;
    if (auto s = list(words, "intensity", vertical.size() * horizontal.size(), values, options_.name);
        !s.ok())
      return s;
    const auto negative = std::ranges::count_if(values, [](double v) { return v < 0; });
    if (negative > 0) {
      warn(words.line(), absl::StrCat(negative, " intensities are negative, and read as 0"));
      for (double& value : values) value = std::max(value, 0.0);
    }
    put_table(std::move(vertical), std::move(horizontal), values);
    if (const std::string what = fault_of(l_); !what.empty()) return fault(line_of_angles, 0, what);
    return absl::OkStatus();
  }

  /// Files go through vertical angles for each horizontal one; planes of B are at vertical angles.
  void put_table(std::vector<double> vertical, std::vector<double> horizontal,
                 const std::vector<double>& values) {
    if (l_.system != PlaneSystem::kB) {
      l_.plane_degrees = std::move(horizontal), l_.polar_degrees = std::move(vertical);
      l_.values = values;
      return;
    }
    for (std::size_t v = 0; v < vertical.size(); ++v) {
      for (std::size_t h = 0; h < horizontal.size(); ++h)
        l_.values.push_back(values[h * vertical.size() + v]);
    }
    l_.plane_degrees = std::move(vertical), l_.polar_degrees = std::move(horizontal);
  }

  const Lines& lines_;
  const LampFileOptions& options_;
  std::vector<std::string>& warnings_;
  Luminaire l_;
  std::string_view tilt_;
  std::size_t head_end_ = 0;  // the line behind TILT=
  double vertical_ = 0, horizontal_ = 0;
};

}  // namespace

bool is_ies(std::string_view bytes) {
  const Lines lines = lines_of(bytes);
  if (lines.empty()) return false;
  return year_of(lines[0]) != 1986 ||
         std::ranges::any_of(lines, [](std::string_view line) { return tilt_of(line).has_value(); });
}

absl::StatusOr<Luminaire> read_ies(std::string_view bytes, const LampFileOptions& options,
                                   std::vector<std::string>& warnings) {
  const Lines lines = lines_of(bytes);
  auto luminaire = IesReader(lines, options, warnings).read();
  if (!luminaire.ok()) return luminaire.status();
  for (const std::string& warning : flux_warnings(*luminaire))
    warnings.push_back(absl::StrCat(options.name, ": ", warning));
  return luminaire;
}

absl::StatusOr<Luminaire> read_lamp_file(std::string_view bytes, const LampFileOptions& options,
                                         std::vector<std::string>& warnings) {
  return is_ies(bytes) ? read_ies(bytes, options, warnings) : read_eulumdat(bytes, options, warnings);
}

}  // namespace tessera::photometry
