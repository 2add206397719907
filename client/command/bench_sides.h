// The processes that `tessera bench` measures whole: this program, and peers.
#pragma once

#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "bench/whole.h"

namespace tessera::client {

struct SideOptions {
  bool whole = false;
  std::vector<std::string> peers;            // command lines with {scene}, {spp}, {seed}, {threads}, {out}
  std::vector<std::string> peer_references;  // one for each scene; empty: none are given
  std::vector<std::string> job_words;        // options that `render` gets as well

  bool any() const { return whole || !peers.empty(); }
};

/// One way of this program to render the scene.
struct OwnSide {
  std::string name;        // empty: the only one
  std::string option;      // "--OPTION=VALUE" that makes the difference; empty: none
  std::uint64_t seed = 0;  // the job's
};

struct SideScene {
  std::string file;
  std::vector<OwnSide> own;
  const BenchReference& reference;
  std::optional<std::string> peer_reference;  // a file
  std::uint32_t reference_spp = 0;  // samples of references that peers make for themselves; 0: none do
};

/// InvalidArgument for a command line of a peer that cannot be filled in.
absl::Status check_peers(const SideOptions& options);

absl::StatusOr<std::vector<WholeResult>> measure_sides(
    const SideOptions& options, const SideScene& scene, const BenchPlan& plan,
    const std::function<void(const std::string&)>& progress, std::stop_token stop);

}  // namespace tessera::client
