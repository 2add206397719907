// The algorithms of these kernels. Each puts itself into the list at the end of its file, under the name that
// its traits have (wire/algorithm.cpp).
#pragma once

#include <algorithm>
#include <memory>
#include <span>

#include "render/integrator/integrator.h"
#include "render/integrator/stage_timer.h"

namespace tessera::render::TESSERA_ISA {

/// In no particular order.
std::span<const Algorithm> listed_algorithms();

/// Adds an algorithm when the kernels are loaded: const ListedAlgorithm toy{{"toy", &make<Toy>}};
class ListedAlgorithm {
 public:
  explicit ListedAlgorithm(const Algorithm& algorithm);
};

/// Algorithm::make. Memory for the paths, new for every unit, is part of what starting them costs.
template <class T>
std::unique_ptr<Integrator> make(const IntegratorContext& context) {
  const StageTimer timer(context.stats.times, Stage::kCamera);
  return std::make_unique<T>(context);
}

/// The same, with one event on a path at most.
template <class T, auto... kHow>
std::unique_ptr<Integrator> make_for_one_event(const IntegratorContext& context) {
  const StageTimer timer(context.stats.times, Stage::kCamera);
  return std::make_unique<T>(context, std::min(context.scene.max_depth, 1), kHow...);
}

}  // namespace tessera::render::TESSERA_ISA
