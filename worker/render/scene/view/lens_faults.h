// Faults of the lens of a camera.
#pragma once

#include <string>
#include <vector>

#include "google/protobuf/message.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

struct LensFault {
  const google::protobuf::Message* element;  // part of the camera's message
  int field;                                 // number of its field; 0: all of it
  std::string message;
};

/// All faults of a thin lens or a lens system, but for image files; empty where the camera has neither.
std::vector<LensFault> lens_faults_of(const v1::Camera& camera);

}  // namespace tessera::render
