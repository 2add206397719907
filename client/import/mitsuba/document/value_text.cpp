#include "import/mitsuba/document/value_text.h"

#include <algorithm>
#include <cctype>
#include <charconv>

#include "import/input/concat.h"
#include "wire/scene_numbers.h"

namespace tessera::client::mitsuba {
namespace {

constexpr std::string_view kSpace = " \t\r\n";
constexpr std::string_view kSeparators = ", \t\r\n";

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kSpace);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kSpace) - begin + 1);
}

std::vector<std::string_view> split_at(std::string_view text, std::string_view separators) {
  std::vector<std::string_view> words;
  for (std::size_t begin = text.find_first_not_of(separators); begin != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(separators, begin), text.size());
    words.push_back(text.substr(begin, end - begin));
    begin = text.find_first_not_of(separators, end);
  }
  return words;
}

std::string add_sample(double wavelength_nm, double value, spectra::Curve& curve) {
  const float nm = static_cast<float>(wavelength_nm);
  if (!curve.nm.empty() && !(nm > curve.nm.back())) {
    return concat("wavelengths must ascend, but ", wavelength_nm, " nm follows ", curve.nm.back(), " nm");
  }
  if (value < 0) return concat("the value at ", wavelength_nm, " nm is ", value, ", which is negative");
  curve.nm.push_back(nm);
  curve.values.push_back(static_cast<float>(value));
  return "";
}

}  // namespace

std::vector<std::string_view> split(std::string_view text) { return split_at(text, kSeparators); }

std::optional<double> parse_float(std::string_view text) {
  text = trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  if (result.ptr != end || text.empty()) return std::nullopt;
  // Too small for a double is zero; too large is an error.
  if (result.ec == std::errc::result_out_of_range) {
    return text.find("e-") != std::string_view::npos || text.find("E-") != std::string_view::npos
               ? std::optional(0.0)
               : std::nullopt;
  }
  if (result.ec != std::errc{} || !wire::is_scene_number(value)) return std::nullopt;
  return value;
}

std::optional<std::int64_t> parse_integer(std::string_view text) {
  text = trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  std::int64_t value = 0;
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  if (result.ec != std::errc{} || result.ptr != end) return std::nullopt;
  return value;
}

std::optional<bool> parse_boolean(std::string_view text) {
  std::string lower;
  for (const char c : trimmed(text))
    lower.push_back(static_cast<char>(std::tolower(static_cast<unsigned char>(c))));
  if (lower == "true") return true;
  if (lower == "false") return false;
  return std::nullopt;
}

std::optional<std::vector<double>> parse_floats(std::string_view text) {
  std::vector<double> numbers;
  for (const std::string_view word : split(text)) {
    const std::optional<double> number = parse_float(word);
    if (!number) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

std::string parse_spectrum(std::string_view text, SpectrumData& spectrum) {
  const std::vector<std::string_view> words = split(text);
  if (words.size() == 1 && words.front().find(':') == std::string_view::npos) {
    const std::optional<double> value = parse_float(words.front());
    if (!value) return concat("expected ", wire::kSceneNumberRange, ", found \"", words.front(), "\"");
    spectrum.uniform = *value;
    return "";
  }
  for (const std::string_view word : words) {
    const std::vector<std::string_view> pair = split_at(word, ":");
    const std::optional<double> nm = pair.size() == 2 ? parse_float(pair[0]) : std::nullopt;
    const std::optional<double> value = pair.size() == 2 ? parse_float(pair[1]) : std::nullopt;
    if (!nm || !value) return concat("expected wavelength:value, found \"", word, "\"");
    if (std::string problem = add_sample(*nm, *value, spectrum.samples); !problem.empty()) return problem;
  }
  if (spectrum.samples.values.size() < 2) return "expected one number or at least two pairs wavelength:value";
  return std::string(spectra::check_curve(spectrum.samples).message());
}

std::string parse_spectrum_file(std::string_view bytes, SpectrumData& spectrum) {
  std::size_t line_number = 0;
  while (!bytes.empty()) {
    ++line_number;
    const std::size_t end = std::min(bytes.find('\n'), bytes.size());
    std::string_view line = bytes.substr(0, end);
    bytes.remove_prefix(std::min(end + 1, bytes.size()));
    line = line.substr(0, line.find('#'));
    const std::optional<std::vector<double>> numbers = parse_floats(line);
    if (numbers && numbers->empty()) continue;
    if (!numbers || numbers->size() != 2)
      return concat("line ", line_number, ": expected a wavelength and a value");
    std::string problem = add_sample((*numbers)[0], (*numbers)[1], spectrum.samples);
    if (!problem.empty()) return concat("line ", line_number, ": ", problem);
  }
  if (spectrum.samples.values.size() < 2) return "expected at least two lines of wavelength and value";
  return std::string(spectra::check_curve(spectrum.samples).message());
}

}  // namespace tessera::client::mitsuba
