#include "command/jobs/auto_choice.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "base/cpu_time.h"
#include "local/bench_scene.h"
#include "local/local_farm.h"
#include "pilot/pilot.h"
#include "wire/algorithm.h"
#include "wire/algorithm_fit.h"
#include "wire/limits.h"

namespace tessera::client {
namespace {

/// Integrators that a pilot tries, the usual one first. `volpath` takes the place of `path` where there are
/// media.
constexpr const char* kTried[] = {"path", "volpath", "bdpt", "vcm", "light"};

/// PilotCandidate::ways.
int ways_of(const wire::AlgorithmTraits& algorithm) {
  const bool both_ends = algorithm.starts_at_lights && algorithm.first_hit_aovs;
  return 1 + (both_ends ? 1 : 0) + (algorithm.bias == wire::Bias::kConsistent ? 1 : 0);
}

/// An integrator that may render the job, or why it may not.
struct Candidate {
  const wire::AlgorithmTraits* algorithm = nullptr;
  std::unique_ptr<PreparedJob> job;
  absl::Status refusal;
};

std::vector<Candidate> candidates_of(const JobSettings& request, const ImportedScene& imported,
                                     const std::string& name) {
  std::vector<Candidate> candidates;
  const bool media = imported.scene.media_size() > 0;
  for (const char* tried : kTried) {
    const wire::AlgorithmTraits* const algorithm = wire::find_algorithm(tried);
    // Without media, path and volpath are the same.
    if (algorithm == nullptr || (tried == std::string("volpath") && !media)) continue;
    Candidate& candidate = candidates.emplace_back(Candidate{algorithm, nullptr, {}});
    v1::Algorithms algorithms;
    algorithms.set_integrator(tried);
    if (const std::string obstacle = wire::obstacle_to(algorithms, imported.scene); !obstacle.empty()) {
      candidate.refusal = absl::InvalidArgumentError(obstacle);
      continue;
    }
    JobSettings own = request;
    own.settings.set_integrator(tried);
    absl::StatusOr<std::unique_ptr<PreparedJob>> job = prepare_job(own, imported, name);
    if (job.ok()) {
      candidate.job = *std::move(job);
    } else {
      candidate.refusal = job.status();
    }
  }
  return candidates;
}

/// Renders the candidates' jobs on small films. Builds of one scene share what they have in common.
class SceneRenderer final : public PilotRenderer {
 public:
  /// `start`: the process's CPU time when the pilot began. The options outlive the renderer.
  SceneRenderer(std::span<const PreparedJob* const> jobs, std::string isa, const ChoiceOptions& options,
                std::stop_token stop, std::chrono::nanoseconds start)
      : jobs_(jobs),
        isa_(std::move(isa)),
        options_(options),
        stop_(std::move(stop)),
        start_(start),
        scenes_(jobs.size()) {}

  absl::StatusOr<double> frame(std::size_t candidate, const PilotFrame& frame) override {
    v1::JobSpec spec = jobs_[candidate]->spec;
    spec.mutable_farm()->set_isa(isa_);
    spec.mutable_view()->set_width(frame.film_width);
    spec.mutable_view()->set_height(frame.film_height);
    spec.mutable_view()->clear_aovs();
    spec.mutable_view()->clear_layers();
    v1::PixelRect& crop = *spec.mutable_cut()->mutable_crop();
    crop.set_x0(frame.x0), crop.set_y0(frame.y0), crop.set_x1(frame.x1), crop.set_y1(frame.y1);
    absl::StatusOr<std::unique_ptr<BenchScene>> scene =
        BenchScene::load(spec, jobs_[candidate]->blobs, options_.threads, contents_.get(), stop_);
    if (!scene.ok()) return scene.status();
    scenes_[candidate] = *std::move(scene);
    frame_ = frame;
    return options_.sample_cpu_seconds ? 0 : scenes_[candidate]->build_cpu_seconds();
  }

  std::string unseen_light(std::size_t candidate) const override {
    const auto ready = std::ranges::find_if(scenes_, [](const auto& scene) { return scene != nullptr; });
    return (*ready)->unseen_light(integrator_of(candidate));
  }

  absl::StatusOr<PilotImage> render(std::size_t candidate, std::uint32_t sample_begin,
                                    std::uint32_t sample_end, std::uint64_t seed_offset) override {
    const absl::StatusOr<BenchRender> rendered =
        scenes_[candidate]->render(sample_begin, sample_end, seed_offset, stop_);
    if (!rendered.ok()) return rendered.status();
    double cpu_seconds = rendered->cost.cpu_seconds;
    if (options_.sample_cpu_seconds) {
      const std::size_t samples = frame_.pixels() * (sample_end - sample_begin);
      cpu_seconds = options_.sample_cpu_seconds(integrator_of(candidate)) * static_cast<double>(samples);
      told_seconds_ += cpu_seconds;
    }
    PilotImage image{std::vector<float>(3 * frame_.pixels()), sample_begin, sample_end, cpu_seconds};
    for (const wire::TileResult& tile : rendered->tiles) copy(tile, image);
    return image;
  }

  /// The scene of a candidate that was made ready; null otherwise.
  std::shared_ptr<const BuiltScene> take_scene(std::size_t candidate) {
    if (scenes_[candidate] == nullptr) return nullptr;
    return std::make_shared<BuiltScene>(BuiltScene{contents_, std::move(scenes_[candidate])});
  }

  double spent_seconds() const override {
    if (options_.sample_cpu_seconds) return told_seconds_;
    return base::in_seconds(base::process_cpu_time() - start_);
  }

 private:
  const std::string& integrator_of(std::size_t candidate) const {
    return jobs_[candidate]->spec.content().algorithms().integrator();
  }
  /// The means of a tile's pixels. Its first channels are red, green and blue.
  void copy(const wire::TileResult& tile, PilotImage& image) const {
    const std::size_t width = tile.x1 - tile.x0, pixels = tile.pixel_count();
    for (std::size_t i = 0; i < pixels; ++i) {
      const std::size_t at =
          (tile.y0 - frame_.y0 + i / width) * frame_.width() + tile.x0 - frame_.x0 + i % width;
      for (std::size_t channel = 0; channel < 3; ++channel) {
        const float mean =
            tile.values[channel * pixels + i] / static_cast<float>(std::max(tile.counts[i], 1u));
        image.values[channel * frame_.pixels() + at] = std::isfinite(mean) ? mean : 0.0f;
      }
    }
  }

  const std::span<const PreparedJob* const> jobs_;
  const std::string isa_;
  const ChoiceOptions& options_;
  const std::stop_token stop_;
  const std::chrono::nanoseconds start_;
  const std::shared_ptr<render::SharedContents> contents_ = make_shared_contents();
  std::vector<std::unique_ptr<BenchScene>> scenes_;
  PilotFrame frame_;
  std::atomic<double> told_seconds_ = 0;  // CPU time of all pictures so far by options_.sample_cpu_seconds
};

PilotJob pilot_job(const v1::JobSpec& spec) {
  const v1::PixelRect& crop = spec.cut().crop();
  return {.width = spec.view().width(),
          .height = spec.view().height(),
          .x0 = crop.x0(),
          .y0 = crop.y0(),
          .x1 = crop.x1(),
          .y1 = crop.y1(),
          .spp = spec.samples().spp()};
}

/// Why the best of the outcome was taken.
std::string reason_of(const PilotOutcome& outcome, std::span<const PilotEntry> entries) {
  if (!outcome.judged) {
    const auto able = std::ranges::count(outcome.entries, "", &PilotOutcome::Entry::refusal);
    const bool blind = std::ranges::any_of(outcome.entries, &PilotOutcome::Entry::is_blind);
    if (able == 1 && blind) return "the others do not see all of the light";
    if (able == 1) return "no other can render the scene";
    return absl::StrFormat("the job is too short for a pilot: %g %% of it would tell nothing",
                           100 * kPilotShare);
  }
  std::size_t second = entries.size();
  for (std::size_t c = 0; c < entries.size(); ++c) {
    const PilotOutcome::Entry& entry = outcome.entries[c];
    if (c == outcome.best || entry.images == 0 || !entry.judgement.eligible() ||
        !entry.judgement.lacks_light.empty())
      continue;
    if (second == entries.size() ||
        entry.judgement.efficiency() > outcome.entries[second].judgement.efficiency())
      second = c;
  }
  if (second == entries.size()) return "the others do not see all of the light";
  return absl::StrFormat(
      "%.3g times the efficiency of %s%s",
      outcome.entries[outcome.best].judgement.efficiency() / outcome.entries[second].judgement.efficiency(),
      entries[second].name, outcome.is_clear ? "" : ", within the pilot's noise");
}

v1::AutoChoice::Candidate message_of(const PilotOutcome::Entry& entry, const std::string& name,
                                     bool is_best) {
  v1::AutoChoice::Candidate message;
  message.set_integrator(name);
  message.set_left_out(entry.refusal.substr(0, wire::kMaxTextBytes));
  message.set_misses_light(entry.is_blind);
  if (entry.images == 0) return message;
  const Judgement& judgement = entry.judgement;
  message.set_images(entry.images);
  message.set_samples(entry.samples);
  message.set_cpu_seconds(judgement.cpu_seconds);
  message.set_variance(judgement.variance);
  message.set_bias2(judgement.bias2);
  message.set_efficiency(judgement.efficiency());
  message.set_uncertainty(judgement.uncertainty);
  message.set_misses_light(!judgement.lacks_light.empty() || !judgement.varies_less_than.empty());
  if (!judgement.lacks_light.empty()) {
    message.set_left_out(absl::StrCat("lacks light that ", judgement.lacks_light, " sees"));
  } else if (!judgement.varies_less_than.empty()) {
    message.set_left_out(absl::StrCat("varies less than ", judgement.varies_less_than,
                                      ", which has more ways: it missed light"));
  } else if (entry.dropped && !is_best) {
    message.set_left_out("clearly worse before the end");
  }
  return message;
}

v1::AutoChoice message_of(const PilotOutcome& outcome, std::span<const PilotEntry> entries) {
  v1::AutoChoice choice;
  choice.set_reason(reason_of(outcome, entries));
  choice.set_build_seconds(outcome.build_seconds);
  if (outcome.judged) choice.set_width(outcome.frame.width()), choice.set_height(outcome.frame.height());
  std::vector<std::size_t> order;
  for (std::size_t c = 0; c < entries.size(); ++c) order.push_back(c);
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
    const auto rank = [&](std::size_t c) {
      return std::pair(c != outcome.best,
                       outcome.entries[c].images == 0 ? 0.0 : -outcome.entries[c].judgement.efficiency());
    };
    return rank(a) < rank(b);
  });
  for (const std::size_t c : order)
    *choice.add_candidates() = message_of(outcome.entries[c], entries[c].name, c == outcome.best);
  return choice;
}

/// A choice without a pilot.
v1::AutoChoice unmeasured(const v1::JobSpec& job, std::string reason) {
  v1::AutoChoice choice;
  choice.set_reason(std::move(reason));
  choice.add_candidates()->set_integrator(job.content().algorithms().integrator());
  return choice;
}

/// The candidate that was chosen when this job was begun; null where another job was.
Candidate* chosen_before(const ChoiceOptions& options, std::span<Candidate* const> candidates) {
  if (!options.begun) return nullptr;
  v1::JobSpec begun = *options.begun;
  begun.mutable_farm()->clear_auto_choice();
  const auto found = std::ranges::find_if(candidates, [&](const Candidate* candidate) {
    return candidate->job->spec.SerializeAsString() == begun.SerializeAsString();
  });
  return found == candidates.end() ? nullptr : *found;
}

/// The job with the integrator of the one that it continues.
absl::StatusOr<std::unique_ptr<PreparedJob>> as_continued(const JobSettings& request,
                                                          const ImportedScene& scene, const std::string& name,
                                                          const v1::JobSpec& continued) {
  JobSettings own = request;
  own.settings.set_integrator(continued.content().algorithms().integrator());
  absl::StatusOr<std::unique_ptr<PreparedJob>> job = prepare_job(own, scene, name);
  if (!job.ok()) return job.status();
  v1::JobSpec& spec = (*job)->spec;
  *spec.mutable_farm()->mutable_auto_choice() = continued.farm().has_auto_choice()
                                                    ? continued.farm().auto_choice()
                                                    : unmeasured(spec, "the job that is continued has it");
  return job;
}

/// How the first of the candidates became that.
struct Tried {
  v1::AutoChoice choice;
  std::shared_ptr<const BuiltScene> first_scene = nullptr;
};

/// Tries these; puts the best first. `start`: CPU time of the process when all this began.
absl::StatusOr<Tried> try_all(const JobSettings& request, const ChoiceOptions& options,
                              std::chrono::nanoseconds start, std::vector<Candidate*>& able) {
  const std::vector<std::string> isas = local_isas();
  const v1::JobSpec& usual = able.front()->job->spec;
  if (able.size() == 1) return Tried{unmeasured(usual, "no other goes with the settings")};
  if (isas.empty()) return Tried{unmeasured(usual, "this machine has no kernels to try others")};
  std::vector<const PreparedJob*> jobs;
  std::vector<PilotEntry> entries;
  for (const Candidate* candidate : able) {
    jobs.push_back(candidate->job.get());
    entries.push_back({candidate->algorithm->name, candidate->algorithm->bias == wire::Bias::kConsistent,
                       ways_of(*candidate->algorithm)});
  }
  const bool is_known = std::ranges::find(isas, request.isa) != isas.end();
  const std::stop_token stop = options.stop();
  SceneRenderer renderer(jobs, is_known ? request.isa : isas.front(), options, stop, start);
  const absl::StatusOr<PilotOutcome> outcome = run_pilot(entries,
                                                         {.job = pilot_job(usual),
                                                          .read_seconds = options.scene_read_cpu_seconds,
                                                          .keeps_scene = options.keeps_scene,
                                                          .threads = options.threads},
                                                         renderer, stop);
  if (!outcome.ok()) return outcome.status();
  std::swap(able.front(), able[outcome->best]);
  Tried tried{message_of(*outcome, entries), renderer.take_scene(outcome->best)};
  tried.choice.set_pilot_seconds(renderer.spent_seconds());
  return tried;
}

}  // namespace

bool asks_for_choice(const JobSettings& request, const v1::Scene& scene) {
  const std::string& asked = request.settings.integrator();
  return (asked.empty() ? scene.settings().integrator() : asked) == kAutoIntegrator;
}

absl::StatusOr<ChosenJob> choose_job(const JobSettings& request, const ImportedScene& scene,
                                     const std::string& name, const ChoiceOptions& options) {
  if (options.continued) {
    absl::StatusOr<std::unique_ptr<PreparedJob>> job = as_continued(request, scene, name, *options.continued);
    if (!job.ok()) return job.status();
    return ChosenJob{*std::move(job)};
  }
  const std::chrono::nanoseconds start = base::process_cpu_time();
  std::vector<Candidate> candidates = candidates_of(request, scene, name);
  std::vector<Candidate*> able;
  for (Candidate& candidate : candidates) {
    if (candidate.job != nullptr) able.push_back(&candidate);
  }
  if (able.empty()) return candidates.front().refusal;
  if (Candidate* const before = chosen_before(options, able)) {
    *before->job->spec.mutable_farm()->mutable_auto_choice() = options.begun->farm().auto_choice();
    return ChosenJob{std::move(before->job)};
  }
  absl::StatusOr<Tried> tried = try_all(request, options, start, able);
  if (!tried.ok()) return tried.status();
  for (const Candidate& candidate : candidates) {
    if (candidate.refusal.ok()) continue;
    v1::AutoChoice::Candidate& left_out = *tried->choice.add_candidates();
    left_out.set_integrator(candidate.algorithm->name);
    left_out.set_left_out(std::string(candidate.refusal.message().substr(0, wire::kMaxTextBytes)));
  }
  std::unique_ptr<PreparedJob> job = std::move(able.front()->job);
  *job->spec.mutable_farm()->mutable_auto_choice() = std::move(tried->choice);
  return ChosenJob{std::move(job), std::move(tried->first_scene)};
}

}  // namespace tessera::client
