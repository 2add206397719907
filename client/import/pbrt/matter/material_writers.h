// One function for each pbrt material type.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "import/pbrt/matter/textures.h"

namespace tessera::client::pbrt {

/// Gives the name in the scene of another material that this one refers to.
using UseMaterial = std::function<std::string(const std::string& name, SourceLocation where)>;
using MaterialWriter = void (*)(ValueReader& values, const UseMaterial& use, v1::Material& material);

/// Null for a type that pbrt-v4 does not have.
MaterialWriter find_material_writer(std::string_view type);

/// For messages: "diffuse, conductor, ...".
std::string names_of_material_types();

/// u and v of "uroughness", "vroughness", "roughness" behind a prefix ("conductor."), with pbrt's fallbacks.
void write_roughness(ValueReader& values, std::string_view prefix, v1::Roughness& roughness);

/// eta and k behind a prefix; copper where they are absent.
void write_conductor_index(ValueReader& values, std::string_view prefix, v1::ConductorMaterial& conductor);

/// A number that pbrt lets be a texture and the Scene does not: a texture is warned of and gives `fallback`.
float constant_of(ValueReader& values, std::string_view name, double fallback);

// Materials that are replaced by a near one, each with a warning [approximate_materials.cpp].
void write_measured(ValueReader& values, const UseMaterial& use, v1::Material& material);
void write_subsurface(ValueReader& values, const UseMaterial& use, v1::Material& material);

}  // namespace tessera::client::pbrt
