#include "base/nearest_name.h"

#include <algorithm>
#include <limits>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"

namespace tessera::base {
namespace {

// Longer names are no typing errors, and comparing takes the product of the lengths.
constexpr std::size_t kLongestName = 128;
// So many letters may stand for a longer name that begins with them.
constexpr std::size_t kShortestBeginning = 3;

/// Damerau's distance in its restricted form: no part is edited twice.
std::size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> before(b.size() + 1), above(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before.swap(above);
    above.swap(row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + (a[i - 1] != b[j - 1])});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row[b.size()];
}

std::string lower(std::string_view text) {
  std::string result{text};
  absl::AsciiStrToLower(&result);
  return result;
}

}  // namespace

std::string nearest_name(std::string_view name, const std::vector<std::string>& names) {
  if (name.empty() || name.size() > kLongestName) return "";
  const std::string wanted = lower(name);
  std::string nearest;
  std::size_t least = std::numeric_limits<std::size_t>::max();
  for (const std::string& candidate : names) {
    if (candidate.empty() || candidate.size() > kLongestName) continue;
    const std::string other = lower(candidate);
    const std::size_t most = std::max<std::size_t>(1, std::max(wanted.size(), other.size()) / 3);
    std::size_t away = distance(wanted, other);
    if (away > most && wanted.size() >= kShortestBeginning && other.starts_with(wanted)) away = most;
    if (away > most || away >= least) continue;
    least = away;
    nearest = candidate;
  }
  return nearest;
}

std::string did_you_mean(std::string_view name, const std::vector<std::string>& names) {
  const std::string nearest = nearest_name(name, names);
  return nearest.empty() ? "" : absl::StrCat("; did you mean '", nearest, "'?");
}

}  // namespace tessera::base
