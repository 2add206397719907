// Judge of a file with a bad number in it: an error that says where, or a picture of finite pixels;
// and soon.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "import/input/imported_scene.h"

namespace tessera::stress {

/// How often cases came out which way.
struct Tally {
  std::uint64_t refused_by_importer = 0, refused_by_renderer = 0, rendered = 0;
  // Part of the rendered: samples beyond what a pixel can sum count as black.
  std::uint64_t with_dropped_samples = 0;

  std::uint64_t cases() const { return refused_by_importer + refused_by_renderer + rendered; }
  std::string to_string() const;
};

class InputJudge {
 public:
  InputJudge();
  ~InputJudge();
  InputJudge(const InputJudge&) = delete;
  InputJudge& operator=(const InputJudge&) = delete;

  /// Imports the scene file and, if the importer takes it, renders it. What is wrong with how that went, or
  /// nothing. `bad_file`: whose name an importer's error must hold (with a line, where it is a text); the
  /// scene file's own if empty.
  std::string judge_file(const std::filesystem::path& path, const std::filesystem::path& bad_file = {});

  /// Judges a scene like the worker gets it: any message at all.
  std::string judge_scene(const v1::Scene& scene, const std::vector<client::SceneBlob>& blobs);

  const Tally& tally() const { return tally_; }

 private:
  class Watchdog;

  std::string render(const v1::Scene& scene, const std::vector<client::SceneBlob>& blobs,
                     const std::string& file);

  std::unique_ptr<Watchdog> watchdog_;
  std::string isa_;
  Tally tally_;
};

}  // namespace tessera::stress
