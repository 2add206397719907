// The light models by name; only light.cpp chooses between them.
#pragma once

#include "render/light/light.h"

namespace tessera::render::TESSERA_ISA {

const LightModel& point_light();
const LightModel& spot_light();
const LightModel& distant_light();
const LightModel& infinite_light();
const LightModel& triangle_light();
const LightModel& rectangle_light();
const LightModel& sphere_light();
const LightModel& disk_light();
const LightModel& cylinder_light();
const LightModel& projection_light();
const LightModel& goniometric_light();

}  // namespace tessera::render::TESSERA_ISA
