// The models of a family (BSDFs, lights, sensors, shapes), one for each kind. A model puts itself into its
// family's table when the kernels are loaded, so that its file and its kind are all that names it.
#pragma once

#include <cassert>
#include <cstddef>

namespace tessera::render::TESSERA_ISA {

/// Models by kind. `Kind` is an enum of numbers from 0 that ends with kCount; kinds from kCount on are added.
template <class Model, class Kind>
class ModelTable {
 public:
  constexpr ModelTable() = default;

  /// Null for a kind without a model.
  const Model* operator[](Kind kind) const { return models_[static_cast<std::size_t>(kind)]; }
  /// Number of kinds.
  std::size_t size() const { return size_; }

  /// Gives a kind of the enum its model. When the kernels are loaded: not thread-safe.
  void set(Kind kind, const Model& model) {
    assert(kind < Kind::kCount && (*this)[kind] == nullptr);
    models_[static_cast<std::size_t>(kind)] = &model;
  }
  /// Returns a new kind with this model. Before anything is rendered: not thread-safe.
  Kind add(const Model& model) {
    assert(size_ < kMost);
    models_[size_] = &model;
    return static_cast<Kind>(size_++);
  }

 private:
  static constexpr std::size_t kMost = 64;

  const Model* models_[kMost] = {};
  std::size_t size_ = static_cast<std::size_t>(Kind::kCount);
};

/// Holds the one object of a model's class, and gives it to a kind by the family's set_model(). Stands at the
/// end of the model's file: const ModelOf<ToyBsdf> toy(BsdfKind::kToy);
template <class Model>
class ModelOf {
 public:
  template <class Kind, class... Arguments>
  explicit ModelOf(Kind kind, const Arguments&... arguments) : model_(arguments...) {
    set_model(kind, model_);
  }

 private:
  const Model model_;
};

}  // namespace tessera::render::TESSERA_ISA
