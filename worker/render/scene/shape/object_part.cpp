#include "render/scene/shape/object_part.h"

#include <algorithm>

namespace tessera::render {

Transform ObjectPart::at(double time) const {
  if (!moves()) return place;
  Transform all = way.front().at(time);
  for (std::size_t i = 1; i < way.size(); ++i) all = all * way[i].at(time);
  return all;
}

int ObjectPart::segments() const {
  const Motion* moving = nullptr;
  int segments = 0;
  for (const Motion& motion : way) {
    if (!motion.moves()) continue;
    segments =
        moving == nullptr ? motion.segments() : std::max(segments, segments_of_product(*moving, motion));
    moving = &motion;
  }
  return segments;
}

ObjectPart ObjectPart::placed_by(const Motion& motion) const {
  if (!moves() && !motion.moves()) return {object, motion.at(0) * place, {}};
  ObjectPart part{object, {}, {motion}};
  if (moves()) {
    part.way.insert(part.way.end(), way.begin(), way.end());
  } else {
    part.way.emplace_back(place);
  }
  return part;
}

}  // namespace tessera::render
