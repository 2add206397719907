#include "command/light_field/read_numbers.h"

#include <cmath>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace tessera::client {
namespace {

template <std::size_t N>
absl::StatusOr<std::array<double, N>> parse_reals(std::string_view text) {
  const std::vector<std::string> words = absl::StrSplit(absl::string_view(text.data(), text.size()), ',');
  std::array<double, N> numbers{};
  bool sound = words.size() == N;
  for (std::size_t i = 0; sound && i < N; ++i)
    sound = absl::SimpleAtod(words[i], &numbers[i]) && std::isfinite(numbers[i]);
  if (sound) return numbers;
  return absl::InvalidArgumentError(absl::StrCat("expected ", N, " numbers with commas between them"));
}

}  // namespace

absl::StatusOr<std::pair<std::uint32_t, std::uint32_t>> parse_counts(std::string_view text) {
  const std::vector<std::string> words = absl::StrSplit(absl::string_view(text.data(), text.size()), 'x');
  std::uint32_t columns = 0, rows = 0;
  constexpr std::uint32_t kMost = 4096;
  if (words.size() == 2 && absl::SimpleAtoi(words[0], &columns) && absl::SimpleAtoi(words[1], &rows) &&
      columns > 0 && rows > 0 && columns <= kMost && rows <= kMost) {
    return std::pair(columns, rows);
  }
  return absl::InvalidArgumentError("expected COLUMNSxROWS, as in 17x17");
}

absl::StatusOr<std::array<double, 2>> parse_pair(std::string_view text) { return parse_reals<2>(text); }
absl::StatusOr<std::array<double, 3>> parse_triple(std::string_view text) { return parse_reals<3>(text); }
absl::StatusOr<std::array<double, 6>> parse_six(std::string_view text) { return parse_reals<6>(text); }

}  // namespace tessera::client
