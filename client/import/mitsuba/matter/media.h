// Mitsuba media, phase functions and volumes -> Medium messages.
#pragma once

#include <map>
#include <set>
#include <string>

#include "import/mitsuba/matter/colors.h"

namespace tessera::client::mitsuba {

class MediumTable {
 public:
  explicit MediumTable(Context& context) : context_(context) {}

  /// The name in the scene of a medium.
  std::string use(Object& medium);

 private:
  /// `world_from_volume` places the unit cube.
  v1::VolumeValue volume(PropertyReader& reader, std::string_view name, double fallback, ColorUse use,
                         Imath::M44d& world_from_volume);
  v1::VolumeValue grid(Object& volume, Imath::M44d& world_from_grid);
  void write_phase(PropertyReader& reader, v1::Medium& message);

  Context& context_;
  std::map<const Object*, std::string> names_;
  std::set<std::string> taken_;
};

}  // namespace tessera::client::mitsuba
