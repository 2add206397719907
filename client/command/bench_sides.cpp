#include "command/bench_sides.h"

#include <deque>
#include <filesystem>

#include "absl/strings/str_cat.h"

namespace tessera::client {
namespace {

using Words = std::vector<std::string>;

WholeSide own_side(const OwnSide& own, const std::string& program, const SideOptions& options,
                   const SideScene& scene, int threads) {
  const auto command = [own, program, words = options.job_words, file = scene.file, threads](
                           std::uint32_t spp, std::uint64_t seed,
                           const std::string& output) -> absl::StatusOr<Words> {
    Words line{program, "render", file, "--quiet"};
    line.insert(line.end(), words.begin(), words.end());
    if (!own.option.empty()) line.push_back(own.option);
    for (const std::string& word : {absl::StrCat("--spp=", spp), absl::StrCat("--seed=", own.seed + seed),
                                    absl::StrCat("--threads=", threads), absl::StrCat("--output=", output)})
      line.push_back(word);
    return line;
  };
  return {own.name.empty() ? "tessera" : own.name, command, &scene.reference};
}

absl::StatusOr<Words> peer_line(const std::string& peer, const std::string& file, std::uint32_t spp,
                                std::uint64_t seed, int threads, const std::string& output) {
  const absl::StatusOr<std::string> line = fill_in(peer, {{"scene", file},
                                                          {"spp", absl::StrCat(spp)},
                                                          {"seed", absl::StrCat(seed)},
                                                          {"threads", absl::StrCat(threads)},
                                                          {"out", output}});
  if (!line.ok()) return absl::InvalidArgumentError(absl::StrCat("--peer: ", line.status().message()));
  return Words{"/bin/sh", "-c", *line};
}

}  // namespace

absl::Status check_peers(const SideOptions& options) {
  for (const std::string& peer : options.peers) {
    if (absl::Status status = peer_line(peer, "", 1, 0, 1, "").status(); !status.ok()) return status;
    for (const char* const name : {"{scene}", "{spp}", "{out}"}) {
      if (peer.find(name) == std::string::npos)
        return absl::InvalidArgumentError(absl::StrCat("--peer: the command lacks ", name));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<WholeResult>> measure_sides(
    const SideOptions& options, const SideScene& scene, const BenchPlan& plan,
    const std::function<void(const std::string&)>& progress, std::stop_token stop) {
  std::error_code error;
  const std::string program = std::filesystem::read_symlink("/proc/self/exe", error).string();
  if (error) return absl::InternalError(absl::StrCat("/proc/self/exe: ", error.message()));
  std::vector<WholeSide> sides;
  for (const OwnSide& own : scene.own) sides.push_back(own_side(own, program, options, scene, plan.threads));

  std::deque<BenchReference> peer_references;  // a deque, whose elements do not move
  if (scene.peer_reference) {
    absl::StatusOr<BenchReference> read = read_reference(*scene.peer_reference, plan.block);
    if (!read.ok()) return read.status();
    peer_references.push_back(*std::move(read));
  }
  for (const std::string& peer : options.peers) {
    const auto command = [&peer, &scene, &plan](std::uint32_t spp, std::uint64_t seed,
                                                const std::string& output) {
      return peer_line(peer, scene.file, spp, seed, plan.threads, output);
    };
    WholeSide side{absl::StrCat("peer ", peer), command, &scene.reference};
    if (scene.peer_reference) {
      side.reference = &peer_references.front();
    } else if (scene.reference_spp > 0) {
      progress(absl::StrCat("reference of a peer, ", scene.reference_spp, " samples a pixel"));
      absl::StatusOr<BenchReference> made = make_reference(side, scene.reference_spp, stop);
      if (!made.ok()) return made.status();
      side.reference = &peer_references.emplace_back(*std::move(made));
    }
    sides.push_back(std::move(side));
  }
  return measure_whole(sides, plan, progress, std::move(stop));
}

}  // namespace tessera::client
