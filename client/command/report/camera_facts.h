// The camera and how its film is exposed, as OpenEXR's standard attributes have them.
#pragma once

#include <string>

#include "image/image.h"
#include "tessera/v1/camera.pb.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::client {

/// Adds "worldToCamera" and, of cameras that project to a plane, "worldToNDC", which takes points to (0, 0)
/// in the upper left and (1, 1) in the lower right corner of the display window [ImfStandardAttributes.h].
/// A camera that moves has those of the time when the shutter opens. Nothing where the camera's transform is
/// singular.
/// Cameras with a lens, a hole or a focal length have "aperture", "pinholeFocalLength" and others, too, and
/// "sensorOverallDimensions", the size of the film.
void add_camera_facts(const v1::Camera& camera, Image& image);

/// Adds what photographers set, where the film, or the words of the job's setting `exposure`, have it:
/// "expTime", "isoSpeed", "aperture", "tStop"; and "whiteLuminance", which follows from that.
void add_exposure_facts(const v1::Film& film, const std::string& words, const v1::Camera& camera,
                        Image& image);

/// Adds "whiteLuminance" where the scene says what luminance a radiance of 1 has, which goes before what the
/// film's exposure says of that.
void add_luminance_facts(const v1::Scene& scene, const std::string& words, const v1::Camera& camera,
                         Image& image);

}  // namespace tessera::client
