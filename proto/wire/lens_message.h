// Lenses of messages as the optics library knows them.
#pragma once

#include <vector>

#include "optics/lens_system.h"
#include "optics/prescription.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::wire {

/// Appends to `faults` what is no glass; optics::faults_of() has the rest.
optics::Prescription prescription_of(const v1::LensPrescription& message, std::vector<optics::Fault>& faults);
/// The reverse.
void write_prescription(const optics::Prescription& lens, v1::LensPrescription& message);

/// Millimetres that a unit of the scene is, for a camera whose numbers are sound.
double mm_per_unit(const v1::LensCamera& camera);
/// The part of a camera's message that a fault of its lens is of: a surface, or a field of the camera.
struct LensFaultPlace {
  const google::protobuf::Message* message = nullptr;
  int field = 0;  // number; 0: all of the message
};
LensFaultPlace place_of(const optics::Fault& fault, const v1::LensCamera& camera);

/// The camera's lens, focused; nothing where `faults` gets why.
std::optional<optics::LensSystem> lens_system_of(const v1::LensCamera& camera,
                                                 std::vector<optics::Fault>& faults);

}  // namespace tessera::wire
