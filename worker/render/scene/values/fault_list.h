// Faults of the elements of a scene.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "google/protobuf/message.h"

namespace tessera::render {

/// An element of a scene that cannot be built.
struct SceneFault {
  const google::protobuf::Message* element;  // part of the scene's message
  std::string place;                         // "shape 12 (lamp)"; empty where the message says it
  std::string message;
  int field = 0;  // number of the element's field that is at fault; 0: not known
};

/// Faults in the order in which builders find them: a load asks for the first one, a client for many.
class FaultList {
 public:
  explicit FaultList(std::size_t most) : most_(most) {}

  bool full() const { return found_.size() >= most_; }
  /// Adds the fault of an element, whose message may begin with the place; not where the list is full, where
  /// the status is OK, or where it is fault_is_told(). `field`: as of SceneFault. Returns whether it is OK.
  bool add(const google::protobuf::Message& element, const std::string& place, const absl::Status& status,
           int field = 0);

  /// The first fault, with its place; OK without any.
  const absl::Status& first() const { return first_; }
  std::vector<SceneFault> take() { return std::move(found_); }

 private:
  const std::size_t most_;
  std::vector<SceneFault> found_;
  absl::Status first_;
};

/// Status of what refers to an element whose fault is in the list, and is itself sound.
absl::Status fault_is_told();

}  // namespace tessera::render
