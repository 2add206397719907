// Which algorithm can render which scene, as far as traits and the Scene message tell.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/scene.pb.h"
#include "wire/algorithm.h"

namespace tessera::wire {

/// Whether builders leave out a shape of this material (null: the usual one): it has no surface, and is no
/// border of a medium.
bool is_nothing(const v1::Shape& shape, const v1::Material* material);

/// Something in a scene that a job's algorithm cannot do. Workers refuse the job, clients do so before them.
struct Obstacle {
  const google::protobuf::Message* element;  // part of the scene's message
  std::string place;                         // "light 3 (sun)"
  std::string reason;                        // behind the algorithm's name: "cannot begin at a portal"

  /// "light 3 (sun): integrator 'bdpt' cannot begin at a portal"
  std::string to_string(const v1::Algorithms& algorithms) const;
};

/// Returns obstacles, `most` of them at most; none where there is no algorithm of that name. Objects that are
/// placed nowhere, and surfaces of nothing, are none. What only building the scene can tell is not among
/// them, such as the memory that radiosity needs.
std::vector<Obstacle> find_obstacles(const v1::Algorithms& algorithms, const v1::Scene& scene,
                                     std::size_t most);

/// InvalidArgument with the text of the first of them.
absl::Status check_obstacles(const v1::Algorithms& algorithms, const v1::Scene& scene);

/// Why the algorithm cannot render all that the scene has, "sees no media", with the first of its obstacles.
/// Empty where it can, or where only building the scene can tell. Media count where they are wanted.
std::string obstacle_to(const v1::Algorithms& algorithms, const v1::Scene& scene, bool wants_media = true);

}  // namespace tessera::wire
