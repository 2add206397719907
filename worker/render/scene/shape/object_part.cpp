#include "render/scene/shape/object_part.h"

namespace tessera::render {

Transform ObjectPart::at(double time) const {
  if (!moves()) return place;
  Transform all = way.front().at(time);
  for (std::size_t i = 1; i < way.size(); ++i) all = all * way[i].at(time);
  return all;
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
