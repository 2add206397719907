// The BSDF models by name; only models.cpp chooses between them.
#pragma once

#include "render/bsdf/bsdf.h"

namespace tessera::render::TESSERA_ISA {

const Bsdf& interface_bsdf();
const Bsdf& diffuse_bsdf();
const Bsdf& conductor_bsdf();
const Bsdf& dielectric_bsdf();
const Bsdf& thin_dielectric_bsdf();
const Bsdf& coated_diffuse_bsdf();
const Bsdf& diffuse_transmission_bsdf();
const Bsdf& plastic_bsdf();
const Bsdf& coated_conductor_bsdf();
const Bsdf& hair_bsdf();
const Bsdf& principled_bsdf();
const Bsdf& principled_thin_bsdf();
const Bsdf& phong_bsdf();
const Bsdf& gltf_bsdf();

}  // namespace tessera::render::TESSERA_ISA
