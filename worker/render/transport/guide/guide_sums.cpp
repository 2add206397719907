#include "render/transport/guide/guide_sums.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "base/split_mix.h"

namespace tessera::render::TESSERA_ISA {

namespace {

constexpr std::size_t kFirstPlaces = std::size_t{1} << 12;

std::uint64_t added(std::uint64_t a, std::uint64_t b) {
  const std::uint64_t sum = a + b;
  return sum < a ? std::numeric_limits<std::uint64_t>::max() : sum;
}

}  // namespace

std::uint64_t guide_value(double value) {
  if (!(value > 0)) return 0;
  return static_cast<std::uint64_t>(std::llround(std::min(value, kMostGuideValue) * kGuideUnit));
}

GuideSums::GuideSums(std::size_t most) : most_(most), table_(kFirstPlaces) {}

std::size_t GuideSums::place_of(std::uint64_t key) const {
  const std::size_t mask = table_.size() - 1;
  std::size_t at = base::split_mix(key) & mask;
  while (table_[at].count != 0 && table_[at].key != key) at = (at + 1) & mask;
  return at;
}

void GuideSums::grow() {
  std::vector<GuideSum> old(table_.size() * 2);
  old.swap(table_);
  for (const GuideSum& sum : old) {
    if (sum.count != 0) table_[place_of(sum.key)] = sum;
  }
}

void GuideSums::add(std::uint64_t key, std::uint64_t value, std::uint64_t count) {
  GuideSum* sum = &table_[place_of(key)];
  if (sum->count == 0) {
    if (size_ == most_) return;
    if (++size_ * 2 > table_.size()) {
      grow();
      sum = &table_[place_of(key)];
    }
    sum->key = key;
  }
  sum->value = added(sum->value, value);
  sum->count = added(sum->count, count);
}

std::vector<GuideSum> GuideSums::sorted() const {
  std::vector<GuideSum> sums;
  sums.reserve(size_);
  std::copy_if(table_.begin(), table_.end(), std::back_inserter(sums),
               [](const GuideSum& sum) { return sum.count != 0; });
  std::ranges::sort(sums, {}, &GuideSum::key);
  return sums;
}

std::vector<GuideSum> added_up(std::vector<GuideSum> sums) {
  std::ranges::sort(sums, {}, &GuideSum::key);
  std::size_t n = 0;
  for (const GuideSum& sum : sums) {
    if (n > 0 && sums[n - 1].key == sum.key) {
      sums[n - 1].value = added(sums[n - 1].value, sum.value);
      sums[n - 1].count = added(sums[n - 1].count, sum.count);
    } else {
      sums[n++] = sum;
    }
  }
  sums.resize(n);
  return sums;
}

}  // namespace tessera::render::TESSERA_ISA
