#include "optics/read/zemax_file.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "base/nearest_name.h"
#include "optics/paraxial.h"
#include "optics/read/number_line.h"

namespace tessera::optics {

namespace {

/// Operands that say nothing about where rays go: what is drawn, optimised, tolerated or listed.
constexpr std::string_view kChangesLight[] = {"COATING", "OBSC", "CLAP", "FLAP", "ELAP", "SQAP", "SQOB",
                                              "UDAP",    "UDOB", "GRIN", "XDAT", "TILT", "PPIC", "MNUM"};

class Reader {
 public:
  explicit Reader(std::vector<Fault>& faults) : faults_(faults) {}

  ZemaxLens read(const std::string& text) {
    for (const TextLine& line : lines_of(text, 0)) read_line(line);
    finish();
    return std::move(result_);
  }

 private:
  struct Row {
    Surface surface;
    bool glass = false;
  };

  template <class... Text>
  void fault(const TextLine& line, std::size_t word, const Text&... text) {
    faults_.push_back({line.number, line.words[std::min(word, line.words.size() - 1)].column,
                       absl::StrCat(std::string(line.words[0].text), ": ", text...)});
  }

  static std::string second_word(const TextLine& line) {
    return line.words.size() > 1 ? std::string(line.words[1].text) : std::string();
  }

  /// The number at a place of the line.
  double number(const TextLine& line, std::size_t word) {
    if (word >= line.words.size()) {
      fault(line, word, "a number is missing");
      return 0;
    }
    const std::string text(line.words[word].text);
    if (const auto value = number_of(text)) return *value;
    fault(line, word, "'", text, "' is no number");
    return 0;
  }

  void read_line(const TextLine& line) {
    const std::string_view word = line.words[0].text;
    if (word == "SURF") return begin_surface(line);
    if (rows_.empty() || !line.indented) return read_header(line, word);
    read_surface(line, word);
  }

  void read_header(const TextLine& line, std::string_view word) {
    if (word == "NAME") {
      for (std::size_t i = 1; i < line.words.size(); ++i)
        absl::StrAppend(&result_.lens.name, i > 1 ? " " : "", std::string(line.words[i].text));
    } else if (word == "MODE" && line.words.size() > 1 && line.words[1].text != "SEQ") {
      fault(line, 1, "only sequential lenses are read");
    } else if (word == "UNIT") {
      read_unit(line);
    } else if (word == "FNUM") {
      result_.f_number = number(line, 1);
    } else if (word == "ENPD") {
      entrance_ = number(line, 1);
    } else if (std::find(std::begin(kChangesLight), std::end(kChangesLight), word) !=
               std::end(kChangesLight)) {
      result_.ignored.push_back(absl::StrCat("line ", line.number, ": ", std::string(word)));
    }
  }

  void read_unit(const TextLine& line) {
    const std::string unit = second_word(line);
    if (unit == "MM") {
      mm_ = 1;
    } else if (unit == "CM") {
      mm_ = 10;
    } else if (unit == "IN") {
      mm_ = 25.4;
    } else if (unit == "METER" || unit == "M") {
      mm_ = 1000;
    } else {
      fault(line, 1, "the unit '", unit, "' is none of MM, CM, IN and METER");
    }
  }

  void begin_surface(const TextLine& line) {
    rows_.emplace_back();
    rows_.back().surface.line = line.number;
    even_ = false;
  }

  void read_surface(const TextLine& line, std::string_view word) {
    Surface& surface = rows_.back().surface;
    if (word == "TYPE") {
      const std::string type = second_word(line);
      even_ = type == "EVENASPH";
      if (type != "STANDARD" && !even_)
        fault(line, 1, "surfaces of type ", type, " are not supported: STANDARD and EVENASPH are");
    } else if (word == "CURV") {
      const double curvature = number(line, 1);
      surface.radius = curvature != 0 ? mm_ / curvature : 0;
    } else if (word == "DISZ") {
      const bool infinite = absl::AsciiStrToUpper(second_word(line)) == "INFINITY";
      surface.thickness = infinite ? HUGE_VAL : mm_ * number(line, 1);
    } else if (word == "DIAM") {
      surface.diameter = 2 * mm_ * number(line, 1);
    } else if (word == "STOP") {
      surface.stop = true;
    } else if (word == "CONI") {
      surface.conic = number(line, 1);
    } else if (word == "GLAS") {
      read_glass(line, surface);
    } else if (word == "PARM" && even_) {
      read_parameter(line, surface);
    } else if (std::find(std::begin(kChangesLight), std::end(kChangesLight), word) !=
               std::end(kChangesLight)) {
      result_.ignored.push_back(absl::StrCat("line ", line.number, ": ", std::string(word)));
    }
  }

  void read_parameter(const TextLine& line, Surface& surface) {
    const double which = number(line, 1), value = number(line, 2);
    if (value == 0) return;
    if (which < 2 || which > 8 || which != std::floor(which))
      return fault(line, 1, "a term of height^", 2 * which, " is not supported: 4 to 16 are");
    const auto place = static_cast<std::size_t>(which) - 2;
    if (surface.aspheric.size() <= place) surface.aspheric.resize(place + 1);
    surface.aspheric[place] = value / std::pow(mm_, 2 * which - 1);
  }

  void read_glass(const TextLine& line, Surface& surface) {
    rows_.back().glass = true;
    if (line.words.size() < 2) return fault(line, 0, "a glass has a name");
    const std::string name(line.words[1].text);
    if (name == "MIRROR") return fault(line, 1, "mirrors are not supported");
    if (const auto known = spectra::find_dispersion(name)) {
      surface.behind.dispersion = *known;
      return;
    }
    const auto given = [&](std::size_t word) {
      return word < line.words.size() ? number_of(line.words[word].text).value_or(0) : 0;
    };
    const double index = given(4), abbe = given(5);
    if (index > 1 && abbe > 0) {
      surface.behind.dispersion = spectra::abbe_dispersion(index, abbe);
    } else if (index > 1) {
      surface.behind.index = index;
    } else {
      fault(line, 1, "there is no glass '", name, "'", base::did_you_mean(name, spectra::dispersion_names()),
            "; nor does the line have its index and Abbe number");
    }
  }

  void finish() {
    if (rows_.size() < 3) {
      faults_.push_back({0, 0, "no lens: a file in Zemax's text format has an object, surfaces and a film"});
      return;
    }
    for (std::size_t i = 1; i + 1 < rows_.size(); ++i) {
      Row& row = rows_[i];
      const bool plane = row.surface.radius == 0 && row.surface.aspheric.empty() && !row.glass;
      auto& surfaces = result_.lens.surfaces;
      const bool in_air = surfaces.empty() || !rows_[i - 1].glass;
      // Planes in air bend nothing: places to which designers refer.
      if (plane && in_air && !row.surface.stop) {
        if (!surfaces.empty()) surfaces.back().thickness += row.surface.thickness;
        continue;
      }
      surfaces.push_back(std::move(row.surface));
    }
    const auto stops = std::count_if(result_.lens.surfaces.begin(), result_.lens.surfaces.end(),
                                     [](const Surface& s) { return s.stop; });
    if (entrance_ > 0 && stops == 1)
      result_.f_number = paraxial_of(result_.lens, kLineD).focal_length() / entrance_;
  }

  std::vector<Fault>& faults_;
  ZemaxLens result_;
  std::vector<Row> rows_;
  double mm_ = 1, entrance_ = 0;
  bool even_ = false;
};

}  // namespace

ZemaxLens read_zemax_lens(std::string_view bytes, std::vector<Fault>& faults) {
  return Reader(faults).read(plain_text(bytes));
}

}  // namespace tessera::optics
