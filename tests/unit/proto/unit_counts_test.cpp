#include "wire/unit_counts.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <variant>

namespace tessera::wire {
namespace {

/// Another number for each count.
RenderCounts numbered(std::uint64_t first) {
  RenderCounts counts;
  for (const RenderCount& count : kRenderCounts) {
    std::visit([&](auto member) { counts.*member += static_cast<decltype(counts.*member + 0)>(first); },
               count.member);
    ++first;
  }
  return counts;
}

TEST(UnitCounts, EveryCountIsAFieldOfTheMessage) {
  for (const RenderCount& count : kRenderCounts) {
    const auto* const field = v1::UnitStats::descriptor()->FindFieldByName(count.name);
    ASSERT_NE(field, nullptr) << count.name;
    using google::protobuf::FieldDescriptor;
    EXPECT_EQ(field->cpp_type(), std::holds_alternative<double RenderCounts::*>(count.member)
                                     ? FieldDescriptor::CPPTYPE_DOUBLE
                                     : FieldDescriptor::CPPTYPE_UINT64)
        << count.name;
  }
}

TEST(UnitCounts, TravelByThemselvesAndAddUp) {
  v1::UnitStats stats;
  set_counts(numbered(1), stats);
  EXPECT_EQ(stats.samples(), 1u);
  EXPECT_EQ(stats.light(), 8.0);
  RenderCounts sum = counts_of(stats);
  sum += numbered(10);
  set_counts(sum, stats);
  for (std::size_t i = 0; i < kRenderCounts.size(); ++i) {
    std::visit([&](auto member) { EXPECT_EQ(counts_of(stats).*member, 11 + 2 * i) << kRenderCounts[i].name; },
               kRenderCounts[i].member);
  }
  EXPECT_EQ(sum.rays(), 13u + 15u + 17u);
}

}  // namespace
}  // namespace tessera::wire
