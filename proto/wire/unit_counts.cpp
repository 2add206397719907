#include "wire/unit_counts.h"

#include <google/protobuf/descriptor.h>

#include <cstddef>
#include <type_traits>

namespace tessera::wire {
namespace {

using google::protobuf::FieldDescriptor;

/// Calls `visit(field, member)` for each count.
template <class Visit>
void for_each_count(Visit visit) {
  static const auto fields = [] {
    std::array<const FieldDescriptor*, kRenderCounts.size()> found{};
    for (std::size_t i = 0; i < found.size(); ++i)
      found[i] = v1::UnitStats::descriptor()->FindFieldByName(kRenderCounts[i].name);
    return found;
  }();
  for (std::size_t i = 0; i < fields.size(); ++i) {
    std::visit([&](auto member) { visit(fields[i], member); }, kRenderCounts[i].member);
  }
}

}  // namespace

RenderCounts counts_of(const v1::UnitStats& stats) {
  const google::protobuf::Reflection& reflection = *stats.GetReflection();
  RenderCounts counts;
  for_each_count([&](const FieldDescriptor* field, auto member) {
    if constexpr (std::is_same_v<decltype(member), double RenderCounts::*>) {
      counts.*member = reflection.GetDouble(stats, field);
    } else {
      counts.*member = reflection.GetUInt64(stats, field);
    }
  });
  return counts;
}

void set_counts(const RenderCounts& counts, v1::UnitStats& stats) {
  const google::protobuf::Reflection& reflection = *stats.GetReflection();
  for_each_count([&](const FieldDescriptor* field, auto member) {
    if constexpr (std::is_same_v<decltype(member), double RenderCounts::*>) {
      reflection.SetDouble(&stats, field, counts.*member);
    } else {
      reflection.SetUInt64(&stats, field, counts.*member);
    }
  });
}

}  // namespace tessera::wire
