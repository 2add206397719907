// Values of accessors.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "import/gltf/rules/rules.h"

namespace tessera::client::gltf {
namespace value_rules {

/// How far lengths may be off 1: what directions of 8 bits a component are off.
constexpr double kUnitTolerance = 0.01;
/// Bounds may have been rounded when they were written.
constexpr double kBoundTolerance = 1e-4;

class ValueCheck {
 public:
  ValueCheck(Context& context, AccessorTable& accessors) : context_(context), accessors_(accessors) {}

  void check(std::size_t index, const Demands& demands) {
    const Json& json = *element(&context_.document, "accessors", index);
    const auto view = index_of(&json, "bufferView");
    const bool is_sparse = member(&json, "sparse") != nullptr;
    if (!view && !is_sparse) return;  // zeros, or what an extension has in their place
    const Accessor& accessor = accessors_[index];
    accessor_ = &accessor, place_ = below("/accessors", index);
    const auto width = static_cast<std::size_t>(accessor.components);
    low_.assign(width, std::numeric_limits<double>::infinity());
    high_.assign(width, -std::numeric_limits<double>::infinity());
    bad_element_ = accessor.count;
    element_.assign(width, 0);
    if (is_sparse) {
      // Replaced values do not count.
      std::vector<float> values(accessor.count * width, 0.0f);
      if (!accessors_.visit(index, [&](std::size_t i, int c, double value) {
            values[i * width + static_cast<std::size_t>(c)] = static_cast<float>(value);
          }))
        return;
      for (std::size_t i = 0; i < values.size(); ++i)
        meet(i / width, static_cast<int>(i % width), double{values[i]}, demands);
    } else if (!accessors_.visit(index,
                                 [&](std::size_t i, int c, double value) { meet(i, c, value, demands); })) {
      return;
    }
    if (bad_element_ < accessor.count) {
      context_.error(place_, concat("element ", bad_element_, " ", fault_));
      return;
    }
    // Filters of compressed data change them a little.
    if (view &&
        extension(element(&context_.document, "bufferViews", *view), "EXT_meshopt_compression") != nullptr)
      return;
    check_bounds(json, "min", low_);
    check_bounds(json, "max", high_);
  }

 private:
  void meet(std::size_t i, int c, double value, const Demands& demands) {
    const auto at = static_cast<std::size_t>(c);
    low_[at] = std::min(low_[at], value), high_[at] = std::max(high_[at], value);
    element_[at] = value;
    if (!std::isfinite(value)) blame(i, "is not finite");
    if (c + 1 == accessor_->components) check_element(i, demands);
  }

  void check_element(std::size_t i, const Demands& demands) {
    if (demands.unit_vectors && !is_unit(3)) blame(i, "is not of length 1");
    if (demands.tangents && !is_unit(3)) blame(i, "has a direction that is not of length 1");
    if (demands.tangents && std::abs(element_[3]) != largest())
      blame(i, "has a sign that is neither 1 nor -1");
    if (demands.rotations && (demands.spline_part == 0 || i % demands.spline_part == 1) && !is_unit(4))
      blame(i, "is not of length 1");
    if (demands.placings && !is_affine()) blame(i, "has a last row that is not 0 0 0 1");
    if (accessor_->components == 1 && demands.vertices != Demands{}.vertices) {
      if (element_[0] == std::exp2(8.0 * static_cast<double>(accessor_->component_size())) - 1)
        blame(i, "is the largest number, which restarts primitives and is no index");
      if (element_[0] >= static_cast<double>(demands.vertices))
        blame(i, concat("is ", element_[0], ", but there are ", demands.vertices, " vertices"));
    }
  }

  /// The number that stands for 1.
  double largest() const {
    const bool is_byte = accessor_->component == Component::kByte;
    return !accessor_->is_integer() ? 1 : is_byte ? 127 : 32767;
  }
  bool is_unit(std::size_t count) const {
    double squared = 0;
    for (std::size_t c = 0; c < count; ++c) squared += element_[c] * element_[c];
    return std::abs(std::sqrt(squared) / largest() - 1) <= kUnitTolerance;
  }
  bool is_affine() const {
    return element_[3] == 0 && element_[7] == 0 && element_[11] == 0 && element_[15] == 1;
  }
  void blame(std::size_t i, const std::string& fault) {
    if (i >= bad_element_) return;
    bad_element_ = i, fault_ = fault;
  }

  void check_bounds(const Json& json, const char* name, const std::vector<double>& actual) {
    const Json* declared = member(&json, name);
    if (declared == nullptr) return;
    for (std::size_t c = 0; c < actual.size(); ++c) {
      const double said = (*declared)[c].get<double>();
      const double scale = std::max({std::abs(low_[c]), std::abs(high_[c]), std::abs(said)});
      if (std::abs(said - actual[c]) <= (accessor_->is_integer() ? 0 : kBoundTolerance * scale)) continue;
      context_.error(below(below(place_, name), c),
                     concat("it says ", said, ", but the data have ", actual[c]));
      return;
    }
  }

  Context& context_;
  AccessorTable& accessors_;
  // The accessor that is looked at.
  const Accessor* accessor_ = nullptr;
  std::string place_;
  std::vector<double> low_, high_, element_;
  std::size_t bad_element_ = 0;
  std::string fault_;
};

}  // namespace value_rules

void check_values(Context& context, AccessorTable& accessors, const AccessorUses& uses) {
  value_rules::ValueCheck check(context, accessors);
  for (std::size_t i = 0; i < size_of(&context.document, "accessors") && !context.diagnostics.full(); ++i) {
    const auto known = uses.all_demands().find(i);
    check.check(i, known == uses.all_demands().end() ? Demands{} : known->second);
  }
}

}  // namespace tessera::client::gltf
