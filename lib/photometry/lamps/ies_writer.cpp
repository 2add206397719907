// IES LM-63 files.
#include <algorithm>
#include <cstddef>

#include "absl/strings/str_cat.h"
#include "photometry/lamps/lamp_file.h"
#include "photometry/units/spelling.h"

namespace tessera::photometry {
namespace {

constexpr std::size_t kLongestLine = 78;

/// Numbers in lines of some length.
class NumberLines {
 public:
  explicit NumberLines(std::string& text) : text_(text) {}
  void add(double value) {
    const std::string number = shortest(value);
    if (length_ > 0 && length_ + 1 + number.size() > kLongestLine) end();
    absl::StrAppend(&text_, length_ > 0 ? " " : "", number);
    length_ += number.size() + (length_ > 0 ? 1 : 0);
  }
  void add(const std::vector<double>& values) {
    for (const double value : values) add(value);
    end();
  }
  void end() {
    if (length_ > 0) text_ += '\n';
    length_ = 0;
  }

 private:
  std::string& text_;
  std::size_t length_ = 0;
};

/// Candelas of a luminaire that came from EULUMDAT, and what else an IES file has of it.
Luminaire as_ies(Luminaire l) {
  if (!l.is_eulumdat) return l;
  const double scale = l.candelas_per_value();
  for (double& value : l.values) value *= scale;
  const EulumdatFields& fields = l.eulumdat;
  if (!fields.sets.empty()) l.watts = fields.sets.front().watts;
  // EULUMDAT has the length of luminaires along C90; IES files along C0.
  l.length = fields.luminous_width / 1000, l.width = fields.luminous_length / 1000;
  if (fields.luminous_width == 0) l.length = l.width = -fields.luminous_length / 1000;
  l.height = fields.luminous_heights[0] / 1000;
  l.feet = false, l.is_eulumdat = false;
  return l;
}

void write_labels(const Luminaire& l, std::string& text) {
  for (const auto& [key, value] : l.labels) {
    std::string_view rest = value;
    bool first = true;
    do {
      const std::size_t end = std::min(rest.find('\n'), rest.size());
      const std::string line(rest.substr(0, end));
      const bool plain = first && key.empty() && !lower(line).starts_with("tilt") && !line.starts_with("[") &&
                         !lower(line).starts_with("ies");
      if (!plain) absl::StrAppend(&text, "[", !first ? "MORE" : key.empty() ? "OTHER" : key, "] ");
      absl::StrAppend(&text, line, "\n");
      rest.remove_prefix(std::min(end + 1, rest.size()));
      first = false;
    } while (!rest.empty());
  }
}

void write_tilt(const LampTilt& tilt, std::string& text) {
  if (tilt.empty()) {
    text += "TILT=NONE\n";
  } else if (!tilt.file.empty()) {
    absl::StrAppend(&text, "TILT=", tilt.file, "\n");
  } else {
    absl::StrAppend(&text, "TILT=INCLUDE\n", tilt.geometry, "\n", tilt.degrees.size(), "\n");
    NumberLines numbers(text);
    numbers.add(tilt.degrees);
    numbers.add(tilt.factors);
  }
}

const char* head_of(int year) {
  switch (year) {
    case 1986:
      return "";
    case 1991:
      return "IESNA91\n";
    case 1995:
      return "IESNA:LM-63-1995\n";
    case 2002:
      return "IESNA:LM-63-2002\n";
    default:
      return "IES:LM-63-2019\n";
  }
}

}  // namespace

absl::StatusOr<std::string> write_ies(const Luminaire& luminaire, int year) {
  if (const std::string fault = fault_of(luminaire); !fault.empty()) return absl::InvalidArgumentError(fault);
  const Luminaire l = as_ies(luminaire);
  if (year == 0) year = l.ies_year != 0 ? l.ies_year : 2019;
  if (year != 1986 && year != 1991 && year != 1995 && year != 2002 && year != 2019)
    return absl::InvalidArgumentError(
        absl::StrCat("there is no LM-63 of ", year, "; those of 1986, 1991, 1995, 2002 and 2019 are"));
  std::string text = head_of(year);
  write_labels(l, text);
  write_tilt(l.tilt, text);
  const bool is_b = l.system == PlaneSystem::kB;
  const std::vector<double>&vertical = is_b ? l.plane_degrees : l.polar_degrees,
        &horizontal = is_b ? l.polar_degrees : l.plane_degrees;
  const double multiplier = year > 1995 ? l.multiplier * l.lamp_ballast_factor : l.multiplier;
  const int system = l.system == PlaneSystem::kC ? 1 : is_b ? 2 : 3;
  absl::StrAppend(&text, l.lamps, " ", shortest(l.lumens_per_lamp), " ", shortest(multiplier), " ",
                  vertical.size(), " ", horizontal.size());
  absl::StrAppend(&text, " ", system, " ", l.feet ? 1 : 2, " ", shortest(l.width), " ", shortest(l.length),
                  " ", shortest(l.height), "\n");
  const double behind = year == 2019 ? l.file_generation : year == 2002 ? 1 : l.lamp_ballast_factor;
  absl::StrAppend(&text, shortest(l.ballast_factor), " ", shortest(behind), " ", shortest(l.watts), "\n");
  NumberLines numbers(text);
  numbers.add(vertical);
  numbers.add(horizontal);
  for (std::size_t h = 0; h < horizontal.size(); ++h) {
    for (std::size_t v = 0; v < vertical.size(); ++v)
      numbers.add(is_b ? l.values[v * horizontal.size() + h] : l.values[h * vertical.size() + v]);
    numbers.end();
  }
  return text;
}

}  // namespace tessera::photometry
