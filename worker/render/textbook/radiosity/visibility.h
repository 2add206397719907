// Rays between patches, a batch at a time.
#pragma once

#include <span>
#include <vector>

#include "render/integrator/integrator.h"
#include "render/textbook/radiosity/patches.h"
#include "render/transport/vertex/lanes.h"

namespace tessera::render::TESSERA_ISA::radiosity {

/// Evenly spread pairs of numbers in [0, 1) [Roberts 2018], from a place of their own for each `key`.
class Spread {
 public:
  explicit Spread(std::uint64_t key);
  double u() const { return at_[0]; }
  double v() const { return at_[1]; }
  void next();

 private:
  double at_[2];
};

class Visibility {
 public:
  static constexpr int kMost = kBatch;

  explicit Visibility(const IntegratorContext& context) : context_(context) {}

  int size() const { return size_; }
  void clear() { size_ = 0; }
  /// Adds a ray between points of two surfaces, whose unit normals are on the sides that face each other.
  void add(const Vec& from, const Vec& normal, const Vec& to, const Vec& to_normal);
  /// Adds a ray from a surface along a unit direction.
  void add(const Vec& from, const Vec& normal, const Vec& direction, double distance);
  /// Asks for all rays that were added; is_free() then knows.
  void trace();
  bool is_free(int ray) const { return distance_[ray] >= 0; }

 private:
  void push(const Vec& origin, const Vec& direction, double distance);

  const IntegratorContext& context_;
  int size_ = 0;
  Vec3Lanes origin_, direction_;
  alignas(64) Lanes<float> distance_;
  alignas(64) Lanes<float> time_ = {};
};

}  // namespace tessera::render::TESSERA_ISA::radiosity
