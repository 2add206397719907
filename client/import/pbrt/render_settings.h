// Integrator, Sampler and Option -> the scene's render settings.
#pragma once

#include "import/pbrt/camera_film.h"

namespace tessera::client::pbrt {

/// "path", "volpath" or "light"; what else pbrt has becomes "volpath", which converges to the same image or
/// says so.
void write_integrator(Context& context, Directive& integrator);

void write_sampler(Context& context, Directive& sampler);

/// `Option "name" value`; `value` is a word, a number or a string.
void write_option(Context& context, const std::string& name, std::string_view value, SourceLocation where);

}  // namespace tessera::client::pbrt
