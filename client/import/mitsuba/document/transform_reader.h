// <transform> with its operations.
#pragma once

#include <string>

#include "import/geometry/transform.h"
#include "pugixml.hpp"

namespace tessera::client::mitsuba {

/// One of <translate>, <rotate>, <scale>, <lookat>, <matrix>, whose parameters have been substituted, applied
/// behind `transform`. The message of what is wrong, or nothing.
std::string apply_operation(const pugi::xml_node& operation, Imath::M44d& transform);

/// x, y and z, or `value` with one or three numbers; the message of what is wrong, or nothing.
std::string read_vector(const pugi::xml_node& node, double fallback, Imath::V3d& vector);

}  // namespace tessera::client::mitsuba
