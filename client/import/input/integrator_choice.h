// Which algorithm of ours renders a scene whose file asks for an integrator of another program.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "tessera/v1/scene.pb.h"

namespace tessera::client {

/// An integrator of another program.
struct IntegratorName {
  std::string_view theirs;
  std::string_view ours;      // the same algorithm, by its name in wire/algorithm.h
  std::string_view stand_in;  // unbiased: renders what `ours` cannot; the same as `ours` where that is right
  bool sees_media = false;    // theirs does: so must what renders instead
};

/// Finds a name in the list, or among our own algorithms. Absent where it is in neither.
std::optional<IntegratorName> find_integrator(std::span<const IntegratorName> names, std::string_view theirs);

/// "path, bdpt, sppm".
std::string list_of(std::span<const IntegratorName> names);

struct IntegratorChoice {
  std::string name;     // an algorithm that there is
  std::string warning;  // where it stands in for another; else empty
};

/// Chooses the algorithm for a scene that is complete but for it: the stand-in where there is no such
/// algorithm here, or where it cannot render the scene.
IntegratorChoice choose_integrator(const IntegratorName& asked, const v1::Scene& scene);

}  // namespace tessera::client
