// Cameras by the sensitivities of their sensors.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "spectra/observer/observer.h"

namespace tessera::spectra {

/// R, G and B of "Nikon D5100", each with a greatest value of 1, as the National Physical Laboratory measured
/// them [Darrodi et al. 2015]; and of "Canon EOS 5D Mark II", relative to the greatest of G, as the Academy
/// publishes them with rawtoaces [Academy 2017].
std::optional<Observer> find_camera(std::string_view name);

/// The names that it knows.
std::vector<std::string> camera_names();

}  // namespace tessera::spectra
