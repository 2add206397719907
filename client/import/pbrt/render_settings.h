// Integrator, Sampler and Option -> the scene's render settings.
#pragma once

#include "import/pbrt/camera_film.h"

namespace tessera::client::pbrt {

/// The path tracer serves all of pbrt's algorithms; says so where it matters. `has_media`: some medium is defined.
void write_integrator(Context& context, Directive& integrator, bool has_media);

void write_sampler(Context& context, Directive& sampler);

/// `Option "name" value`; `value` is a word, a number or a string.
void write_option(Context& context, const std::string& name, std::string_view value, SourceLocation where);

}  // namespace tessera::client::pbrt
