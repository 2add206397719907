#include "command/report/file_facts.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>

#include "absl/strings/str_cat.h"
#include "base/printable.h"
#include "wire/version.h"

namespace tessera::client {
namespace {

/// The words of this process's command line, one behind the other.
std::string command_line() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::string words{std::istreambuf_iterator<char>(file), {}};
  while (!words.empty() && words.back() == '\0') words.pop_back();
  std::ranges::replace(words, '\0', ' ');
  return base::printable(words);
}

/// Two decimal digits, a nibble each.
std::uint32_t digits_of(std::int64_t number) {
  return static_cast<std::uint32_t>(number / 10 % 10 * 16 + number % 10);
}

}  // namespace

void add_file_facts(const std::string& job_name, std::time_t now, Image& image) {
  std::tm local{};
  if (localtime_r(&now, &local) != nullptr) {
    std::array<char, 32> text{};
    if (std::strftime(text.data(), text.size(), "%Y:%m:%d %H:%M:%S", &local) > 0)
      image.metadata["capDate"] = std::string(text.data());
    // UTC is local time plus this.
    image.metadata["utcOffset"] = -static_cast<float>(local.tm_gmtoff);
  }
  if (const auto seconds = image.metadata.find("tessera.render_seconds"); seconds != image.metadata.end())
    image.metadata["renderingTime"] = seconds->second;
  image.metadata.try_emplace(
      "comments", absl::StrCat(base::printable(job_name), ", rendered by Tessera ", wire::build_version()));
  if (std::string line = command_line(); !line.empty())
    image.metadata["tessera.command_line"] = std::move(line);
}

void add_frame_facts(std::int64_t frame, const Rational& rate, double shutter, Image& image) {
  image.metadata["framesPerSecond"] = rate;
  image.metadata["tessera.frame"] = static_cast<std::int32_t>(frame);
  if (shutter > 0) image.metadata["shutterAngle"] = static_cast<float>(360 * shutter);
  if (rate.denominator == 0 || rate.numerator <= 0 || frame < 0) return;
  const std::int64_t base = (rate.numerator + rate.denominator / 2) / rate.denominator;
  // The code has two digits for frames, of which the higher goes to 3.
  if (base < 1 || base > 39) return;
  const std::int64_t seconds = frame / base;
  image.metadata["timeCode"] =
      TimeCode{digits_of(frame % base) | digits_of(seconds % 60) << 8 | digits_of(seconds / 60 % 60) << 16 |
               digits_of(seconds / 3600 % 24) << 24};
}

}  // namespace tessera::client
