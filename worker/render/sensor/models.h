// The sensor models by name; only sensor.cpp chooses between them.
#pragma once

#include "render/sensor/sensor.h"

namespace tessera::render::TESSERA_ISA {

const SensorModel& pinhole_sensor();
const SensorModel& thin_lens_sensor();
const SensorModel& orthographic_sensor();
const SensorModel& orthographic_lens_sensor();
const SensorModel& equirectangular_sensor();
const SensorModel& octahedral_sensor();

}  // namespace tessera::render::TESSERA_ISA
