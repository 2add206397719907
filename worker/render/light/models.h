// The light models by name; only light.cpp chooses between them.
#pragma once

#include "render/light/light.h"

namespace tessera::render::TESSERA_ISA {

class PositionalLight;

const PositionalLight& point_light();
const PositionalLight& spot_light();
const LightModel& distant_light();
const LightModel& infinite_light();
const LightModel& triangle_light();
const LightModel& rectangle_light();
const LightModel& sphere_light();
const LightModel& disk_light();
const LightModel& cylinder_light();
const LightModel& projection_light();
const LightModel& goniometric_light();
const LightModel& soft_point_light();
const LightModel& soft_spot_light();

}  // namespace tessera::render::TESSERA_ISA
