// Indices of refraction by name.
#pragma once

#include <string>

#include "import/mitsuba/document/property_reader.h"

namespace tessera::client::mitsuba {

/// int_ior over ext_ior of a BSDF, each a number or one of Mitsuba's names ("bk7", "water", ...). `interior`
/// is the name where int_ior is absent; ext_ior is air then.
double read_relative_ior(PropertyReader& reader, const std::string& interior);

}  // namespace tessera::client::mitsuba
