#include "photometry/weather/epw.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "base/printable.h"

namespace tessera::photometry {
namespace {

constexpr std::size_t kMostFaults = 20;
constexpr int kHeaderLines = 8;

struct Field {
  std::string_view text;
  int column = 1;
};

constexpr std::string_view kBlanks = " \t\r\v\f";

/// The text of a line between commas, without blanks around it.
std::vector<Field> fields_of(std::string_view line) {
  std::vector<Field> fields;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    const std::size_t first = std::min(line.find_first_not_of(kBlanks, begin), end);
    std::string_view word = line.substr(first, end - first);
    word = word.substr(0, word.find_last_not_of(kBlanks) + 1);
    fields.push_back({word, static_cast<int>(first) + 1});
    begin = end + 1;
  }
  return fields;
}

bool is_blank(std::string_view line) { return line.find_first_not_of(kBlanks) == std::string_view::npos; }

bool equals_ignoring_case(std::string_view a, std::string_view b) {
  return std::ranges::equal(
      a, b, [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

/// Bounds and codes of a field of an hour's line.
struct EpwQuantity {
  const char* name;
  std::size_t index;    // among the fields of the line
  double least, most;   // of values that are there
  double missing_from;  // the code
};
// Order and codes: EnergyPlus, Auxiliary Programs, "EnergyPlus Weather File (EPW) Data Dictionary". Radiation
// has no upper bound there but its code.
constexpr EpwQuantity kDewPoint = {kWeatherFieldNames[0], 7, -90, 70, 99.9};
constexpr EpwQuantity kGlobal = {kWeatherFieldNames[1], 13, 0, 9999, 9999};
constexpr EpwQuantity kDirect = {kWeatherFieldNames[2], 14, 0, 9999, 9999};
constexpr EpwQuantity kDiffuse = {kWeatherFieldNames[3], 15, 0, 9999, 9999};
constexpr std::size_t kFewestFields = 16;

struct Moment {
  int month = 1, day = 1, hour = 1;
  bool operator==(const Moment&) const = default;
};

constexpr int kDays[12] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};

/// The hour of a year after another; `leap`: February has 29 days. Nothing after the last.
std::optional<Moment> next(Moment m, bool leap) {
  if (++m.hour <= 24) return m;
  m.hour = 1;
  const int days = kDays[m.month - 1] + (leap && m.month == 2 ? 1 : 0);
  if (++m.day <= days) return m;
  m.day = 1;
  return ++m.month <= 12 ? std::optional(m) : std::nullopt;
}

std::string told(const Moment& m) {
  return absl::StrCat("day ", m.day, " of month ", m.month, ", hour ", m.hour);
}

class EpwReader {
 public:
  EpwReader(std::string_view text, std::vector<WeatherFault>& faults) : text_(text), faults_(faults) {}

  Weather run() {
    if (text_.starts_with("\xEF\xBB\xBF")) text_.remove_prefix(3);
    read_header();
    while (next_line()) {
      if (!is_blank(line_)) read_hour();
    }
    check_end();
    if (found_ > kMostFaults)
      faults_.push_back({number_, 1, absl::StrCat("and ", found_ - kMostFaults, " more faults")});
    return std::move(weather_);
  }

 private:
  void fault(int column, std::string message) {
    if (++found_ <= kMostFaults) faults_.push_back({number_, column, std::move(message)});
  }

  bool next_line() {
    if (at_ >= text_.size()) return false;
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    line_ = text_.substr(at_, end - at_);
    if (line_.ends_with('\r')) line_.remove_suffix(1);
    at_ = end + 1;
    ++number_;
    return true;
  }

  std::optional<double> number(const Field& field, const char* what) {
    double value = 0;
    const char* const end = field.text.data() + field.text.size();
    const char* const begin = field.text.data() + field.text.starts_with('+');
    const auto [read, error] = std::from_chars(begin, end, value);
    if (error == std::errc() && read == end && std::isfinite(value)) return value;
    fault(field.column, absl::StrCat(what, ": '", base::printable(field.text), "' is no number"));
    return std::nullopt;
  }

  std::optional<double> number_within(const Field& field, const char* what, double least, double most) {
    const auto value = number(field, what);
    if (!value) return value;
    if (*value >= least && *value <= most) return value;
    fault(field.column, absl::StrCat(what, " ", *value, " is not within ", least, " and ", most));
    return std::nullopt;
  }

  std::optional<int> whole_within(const Field& field, const char* what, int least, int most) {
    const auto value = number_within(field, what, least, most);
    if (!value) return std::nullopt;
    if (*value == std::floor(*value)) return static_cast<int>(*value);
    fault(field.column, absl::StrCat(what, " ", *value, " is no whole number"));
    return std::nullopt;
  }

  void read_location() {
    const std::vector<Field> fields = fields_of(line_);
    if (!equals_ignoring_case(fields[0].text, "LOCATION")) {
      return fault(1, "not a weather file of EnergyPlus: its first line begins with LOCATION");
    }
    if (fields.size() < 10) {
      return fault(
          1, absl::StrCat("LOCATION has ", fields.size() - 1,
                          " values; nine are expected: city, region, country, source, station, latitude, "
                          "longitude, hours from universal time, elevation"));
    }
    weather_.city = base::printable(fields[1].text);
    weather_.region = base::printable(fields[2].text);
    weather_.country = base::printable(fields[3].text);
    weather_.place.latitude_degrees = number_within(fields[6], "latitude", -90, 90).value_or(0);
    weather_.place.longitude_degrees = number_within(fields[7], "longitude", -180, 180).value_or(0);
    weather_.utc_offset_hours = number_within(fields[8], "time zone", -14, 14).value_or(0);
    weather_.elevation_metres = number_within(fields[9], "elevation", -1000, 9999.9).value_or(0);
  }

  void read_header() {
    for (int i = 0; i < kHeaderLines; ++i) {
      if (!next_line()) {
        number_ = std::max(number_, 1);
        return fault(1, absl::StrCat("the file ends within its header of eight lines, after ", i));
      }
      if (i == 0) read_location();
      const std::vector<Field> fields = fields_of(line_);
      if (!equals_ignoring_case(fields[0].text, "DATA PERIODS")) continue;
      if (fields.size() < 3) {
        fault(1, "DATA PERIODS does not say how many records an hour has");
      } else if (const auto records = number(fields[2], "records an hour"); records && *records != 1) {
        fault(fields[2].column, absl::StrCat(*records, " records an hour; only files of hours are read"));
      }
    }
  }

  std::optional<double> value_of(const std::vector<Field>& fields, const EpwQuantity& quantity,
                                 int& missing) {
    const Field& field = fields[quantity.index];
    if (field.text.empty()) return ++missing, std::nullopt;
    const auto value = number(field, quantity.name);
    if (!value) return value;
    if (*value >= quantity.missing_from) return ++missing, std::nullopt;
    if (*value >= quantity.least && *value <= quantity.most) return value;
    fault(field.column, absl::StrCat(quantity.name, " ", *value, " is not within ", quantity.least, " and ",
                                     quantity.most));
    return std::nullopt;
  }

  void read_hour() {
    const std::vector<Field> fields = fields_of(line_);
    if (fields.size() < kFewestFields) {
      return fault(1, absl::StrCat("an hour has ", fields.size(), " values; ", kFewestFields,
                                   " are expected at least"));
    }
    const auto year = whole_within(fields[0], "year", 1901, 2099),
               month = whole_within(fields[1], "month", 1, 12), day = whole_within(fields[2], "day", 1, 31),
               hour = whole_within(fields[3], "hour", 1, 24);
    if (!year || !month || !day || !hour) return;
    WeatherHour read{.year = *year, .month = *month, .day = *day, .hour = *hour, .line = number_};
    if (!check_order({read.month, read.day, read.hour}, fields)) return;
    // A typical year takes February of some year: 29 days are days of a leap year.
    if (read.month == 2 && read.day == 29 && read.year % 4 != 0)
      read.year = std::max(read.year - read.year % 4, 1904);
    read.dew_point_celsius = value_of(fields, kDewPoint, weather_.missing[0]);
    read.global_horizontal = value_of(fields, kGlobal, weather_.missing[1]);
    read.direct_normal = value_of(fields, kDirect, weather_.missing[2]);
    read.diffuse_horizontal = value_of(fields, kDiffuse, weather_.missing[3]);
    weather_.hours.push_back(read);
  }

  /// Whether the hour is one after the last; tells those in between.
  bool check_order(const Moment& moment, const std::vector<Field>& fields) {
    if (moment.day > kDays[moment.month - 1] + (moment.month == 2 ? 1 : 0)) {
      fault(fields[2].column, absl::StrCat("month ", moment.month, " has no day ", moment.day));
      return false;
    }
    if (expected_ && moment == *expected_) return follow(moment), true;
    if (expected_ && moment == Moment{2, 29, 1} && *expected_ == Moment{3, 1, 1}) return follow(moment), true;
    int skipped = 0;
    std::optional<Moment> at = expected_;
    while (at && !(*at == moment)) at = next(*at, at->month == 2 && at->day == 29), ++skipped;
    if (!at) {
      fault(1, absl::StrCat(told(moment), " comes after ", last_ ? told(*last_) : "nothing",
                            "; hours of one year are expected in their order"));
      return false;
    }
    fault(1, absl::StrCat(skipped, skipped == 1 ? " hour is" : " hours are", " missing before ", told(moment),
                          ": from ", told(*expected_), " on"));
    follow(moment);
    return true;
  }

  void follow(const Moment& moment) {
    last_ = moment;
    expected_ = next(moment, moment.month == 2 && moment.day == 29);
  }

  void check_end() {
    int missing = 0;
    for (std::optional<Moment> at = expected_; at; at = next(*at, false)) ++missing;
    if (missing == 0) return;
    fault(1, absl::StrCat("the file ends ", last_ ? absl::StrCat("after ", told(*last_)) : "without an hour",
                          "; ", missing, missing == 1 ? " hour of the year is" : " hours of the year are",
                          " missing"));
  }

  std::string_view text_, line_;
  std::size_t at_ = 0;
  int number_ = 0;  // of the line
  std::vector<WeatherFault>& faults_;
  std::size_t found_ = 0;
  Weather weather_;
  std::optional<Moment> expected_ = Moment{}, last_;
};

}  // namespace

Weather read_epw(std::string_view text, std::vector<WeatherFault>& faults) {
  return EpwReader(text, faults).run();
}

}  // namespace tessera::photometry
