#include "import/input/nearest_name.h"

#include <algorithm>

namespace tessera::client {
namespace {

/// Edits between two names: optimal string alignment, three rows at a time.
std::size_t edits_between(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_last(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::swap(before_last, last);
    std::swap(last, row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({replaced, last[j] + 1, row[j - 1] + 1});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
  }
  return row[b.size()];
}

}  // namespace

std::string nearest_name(std::string_view name, const std::vector<std::string>& names) {
  constexpr std::size_t kLongest = 256;  // beyond, a name is not a typing error
  if (name.size() > kLongest) return "";
  const std::string* nearest = nullptr;
  std::size_t fewest = 0;
  for (const std::string& candidate : names) {
    if (candidate.empty() || candidate.size() > kLongest) continue;
    const std::size_t edits = edits_between(name, candidate);
    if (edits > std::max<std::size_t>(1, std::max(name.size(), candidate.size()) / 3)) continue;
    if (nearest != nullptr && edits >= fewest) continue;
    nearest = &candidate;
    fewest = edits;
  }
  return nearest == nullptr ? "" : *nearest;
}

}  // namespace tessera::client
