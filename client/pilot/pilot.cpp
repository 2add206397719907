#include "pilot/pilot.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <mutex>
#include <thread>
#include <utility>

namespace tessera::client {
namespace {

constexpr double kProbePixels = 1024;
constexpr std::uint32_t kProbes = 3;        // the median tells the cost of a sample
constexpr std::uint32_t kFirstImages = 8;   // before anything is judged
constexpr std::uint32_t kUsualImages = 16;  // candidates are dropped from here on
constexpr std::uint32_t kMostImages = 64;
constexpr double kLeastPixels = 192, kMostPixels = 4096;
constexpr std::uint32_t kMostSpp = 16;
constexpr double kClear = 3;  // standard errors
/// Independent pictures have seeds from here on, which neither the job nor bench's references have.
constexpr std::uint64_t kFirstSeed = std::uint64_t{3} << 40;

/// The job's film with about so many of its pixels.
PilotFrame frame_of(const PilotJob& job, double pixels) {
  const double scale = std::min(1.0, std::sqrt(pixels / job.pixels()));
  const auto scaled = [scale](std::uint32_t size) {
    return static_cast<std::uint32_t>(std::max(1.0, std::round(size * scale)));
  };
  PilotFrame frame{.film_width = scaled(job.width), .film_height = scaled(job.height)};
  frame.x0 = std::min(static_cast<std::uint32_t>(job.x0 * scale), frame.film_width - 1);
  frame.y0 = std::min(static_cast<std::uint32_t>(job.y0 * scale), frame.film_height - 1);
  frame.x1 = std::clamp(frame.x0 + scaled(job.x1 - job.x0), frame.x0 + 1, frame.film_width);
  frame.y1 = std::clamp(frame.y0 + scaled(job.y1 - job.y0), frame.y0 + 1, frame.film_height);
  return frame;
}

/// Where the samples of a picture begin: over all of the job's, by the radical inverse in base 2.
std::uint32_t begin_of(std::uint32_t image, std::uint32_t samples, std::uint32_t spp) {
  double place = 0, step = 0.5;
  for (std::uint32_t rest = image; rest > 0; rest /= 2, step /= 2) place += step * (rest % 2);
  return static_cast<std::uint32_t>(place * spp) / samples * samples;
}

class Pilot {
 public:
  Pilot(std::span<const PilotEntry> entries, const PilotPlan& plan, PilotRenderer& renderer,
        std::stop_token stop)
      : entries_(entries), plan_(plan), renderer_(renderer), stop_(std::move(stop)) {
    outcome_.entries.resize(entries.size());
    costs_.resize(entries.size());
  }

  absl::StatusOr<PilotOutcome> run() {
    outcome_.frame = frame_of(plan_.job, kProbePixels);
    absl::StatusOr<bool> goes_on = probe_all();
    if (goes_on.ok() && *goes_on && racing() == 0 && take_back_blind()) goes_on = probe_all();
    if (!goes_on.ok()) return goes_on.status();
    if (racing() == 0) return first_refusal_;
    if (!*goes_on || racing() == 1) return outcome_;
    plan_pictures(left() / cost_of_all());
    for (std::size_t c = 0; c < entries_.size(); ++c) {
      if (absl::Status s = set_frame(c); !s.ok()) return s;
      if (outcome_.entries[c].dropped) continue;
      candidates_.push_back({entries_[c].name, entries_[c].consistent, entries_[c].ways, {}});
      entry_of_.push_back(c);
    }
    for (std::uint32_t images = kFirstImages; racing() > 1 && images <= kMostImages; images *= 2) {
      const std::uint32_t affordable = affordable_images(images);
      if (affordable > done_) {
        if (absl::Status s = render_images(affordable); !s.ok()) return s;
        judge_all();
      }
      if (affordable < images) break;
    }
    return outcome_;
  }

 private:
  /// CPU seconds that the pilot may still take.
  double left() const {
    double quickest = 0;
    for (std::size_t c = 0; c < costs_.size(); ++c) {
      const Judgement& known = outcome_.entries[c].judgement;
      if (costs_[c] == 0 || !known.eligible() || !known.lacks_light.empty() || outcome_.entries[c].is_blind)
        continue;
      quickest = quickest > 0 ? std::min(quickest, costs_[c]) : costs_[c];
    }
    const double job =
        plan_.read_seconds + first_build_seconds_ + quickest * plan_.job.pixels() * plan_.job.spp;
    return kPilotShare * job - renderer_.spent_seconds() + (plan_.keeps_scene ? first_build_seconds_ : 0);
  }

  /// CPU seconds of a sample of a pixel of each that is in the race.
  double cost_of_all() const {
    double sum = 0;
    for (std::size_t c = 0; c < costs_.size(); ++c) sum += outcome_.entries[c].dropped ? 0 : costs_[c];
    return sum;
  }

  /// That of the first which can render the scene.
  double usual_cost() const {
    const auto first = std::ranges::find_if(costs_, [](double cost) { return cost > 0; });
    return first == costs_.end() ? 0 : *first;
  }

  /// Whether the least that tells anything can be rendered, with so many candidates probed. The others cost
  /// as much as the first at least, and one of them needs a scene of its own.
  bool is_enough(std::size_t probed) const {
    const auto others = static_cast<double>(
        std::count_if(outcome_.entries.begin() + static_cast<std::ptrdiff_t>(probed), outcome_.entries.end(),
                      [](const PilotOutcome::Entry& entry) { return !entry.dropped; }));
    const double build = std::ranges::count(costs_, 0.0) + 1 == std::ssize(costs_) ? first_build_seconds_ : 0;
    const double probes = others * usual_cost() * kProbes * static_cast<double>(outcome_.frame.pixels());
    const double pictures =
        (cost_of_all() + others * usual_cost()) * kUsualImages * std::min(kLeastPixels, plan_.job.pixels());
    return left() >= build + probes + pictures;
  }

  absl::Status set_frame(std::size_t candidate) {
    PilotOutcome::Entry& entry = outcome_.entries[candidate];
    if (entry.dropped) return absl::OkStatus();
    const absl::StatusOr<double> seconds = renderer_.frame(candidate, outcome_.frame);
    if (absl::IsInvalidArgument(seconds.status())) {
      entry.dropped = true;
      entry.refusal = std::string(seconds.status().message());
      if (first_refusal_.ok()) first_refusal_ = seconds.status();
      take_first();
      return absl::OkStatus();
    }
    if (!seconds.ok()) return seconds.status();
    outcome_.build_seconds += *seconds;
    if (first_build_seconds_ == 0) first_build_seconds_ = *seconds;
    return absl::OkStatus();
  }

  /// Until somebody is judged, the first that may render the job is the best.
  void take_first() {
    const auto first = std::ranges::find(outcome_.entries, false, &PilotOutcome::Entry::dropped);
    if (first != outcome_.entries.end())
      outcome_.best = static_cast<std::size_t>(first - outcome_.entries.begin());
  }

  /// Leaves out those that never find some of the light, where another finds all.
  void leave_out_blind() {
    std::vector<std::string> unseen;
    for (std::size_t c = 0; c < entries_.size(); ++c) unseen.push_back(renderer_.unseen_light(c));
    is_asked_ = true;
    bool finds_all = false;  // some candidate
    for (std::size_t c = 0; c < entries_.size(); ++c)
      finds_all = finds_all || (unseen[c].empty() && !outcome_.entries[c].dropped);
    if (!finds_all) return;
    for (std::size_t c = 0; c < entries_.size(); ++c) {
      PilotOutcome::Entry& entry = outcome_.entries[c];
      if (unseen[c].empty() || entry.dropped) continue;
      entry.dropped = entry.is_blind = true;
      entry.refusal = std::move(unseen[c]);
    }
    take_first();
  }

  /// Where those that find all of the light cannot render the scene; false where nobody was left out.
  bool take_back_blind() {
    bool any = false;
    for (PilotOutcome::Entry& entry : outcome_.entries) {
      if (!entry.is_blind) continue;
      entry.dropped = entry.is_blind = false;
      entry.refusal.clear();
      any = true;
    }
    if (any) take_first();
    return any;
  }

  /// Probes all that are in the race and were not before. False where the job is too short for more.
  absl::StatusOr<bool> probe_all() {
    for (std::size_t c = 0; c < entries_.size(); ++c) {
      if (outcome_.entries[c].dropped || costs_[c] > 0) continue;
      if (absl::Status s = probe(c); !s.ok()) return s;
      if (!is_asked_ && !outcome_.entries[c].dropped) leave_out_blind();
      // The candidates that are left will hardly be quicker, nor its scene be built in less time.
      if (entries_.size() > 1 && cost_of_all() > 0 && !is_enough(c + 1)) return false;
    }
    return true;
  }

  absl::Status probe(std::size_t candidate) {
    if (absl::Status s = set_frame(candidate); !s.ok() || outcome_.entries[candidate].dropped) return s;
    std::vector<double> times;
    for (std::uint32_t i = 0; i < kProbes; ++i) {
      const auto image = renderer_.render(candidate, 0, 1, kFirstSeed + kMostImages + i);
      if (!image.ok()) return image.status();
      times.push_back(image->cpu_seconds);
    }
    std::ranges::sort(times);
    costs_[candidate] = std::max(1e-12, times[kProbes / 2] / static_cast<double>(outcome_.frame.pixels()));
    return absl::OkStatus();
  }

  /// Decides on pixels and samples of a picture, for so many samples of each candidate. Samples of a pixel
  /// come first: what a sequence gains over chance, and how quickly edges within pixels are averaged, differs
  /// between candidates, and most of it is there with 16.
  void plan_pictures(double samples) {
    const double of_an_image = samples / kUsualImages;
    const auto most = std::min(kMostSpp, std::bit_floor(plan_.job.spp));
    const double fewest = std::min(kLeastPixels, plan_.job.pixels());
    spp_ = std::bit_floor(static_cast<std::uint32_t>(std::clamp<double>(of_an_image / fewest, 1, most)));
    outcome_.frame = frame_of(plan_.job, std::clamp(of_an_image / spp_, kLeastPixels, kMostPixels));
  }

  std::size_t racing() const {
    return static_cast<std::size_t>(
        std::ranges::count(outcome_.entries, false, &PilotOutcome::Entry::dropped));
  }

  /// The number of these images that the time is enough for; it is even.
  std::uint32_t affordable_images(std::uint32_t wanted) const {
    const double cost = cost_of_all() * static_cast<double>(outcome_.frame.pixels()) * spp_;
    const double more = std::clamp<double>(std::floor(left() / cost), 0, wanted - done_);
    const std::uint32_t images = done_ + static_cast<std::uint32_t>(more) / 2 * 2;
    return done_ == 0 ? std::max(images, std::min(wanted, kFirstImages)) : images;
  }

  /// Up to this number of images of each candidate, which take turns.
  absl::Status render_images(std::uint32_t images) {
    struct Task {
      std::size_t candidate;
      std::uint32_t image;
    };
    std::vector<Task> tasks;
    for (std::uint32_t image = done_; image < images; ++image) {
      for (std::size_t i = 0; i < candidates_.size(); ++i) {
        const std::size_t c = image % 2 == 0 ? i : candidates_.size() - 1 - i;
        if (!entry(c).dropped) tasks.push_back({c, image});
      }
    }
    for (std::size_t c = 0; c < candidates_.size(); ++c) {
      if (!entry(c).dropped) candidates_[c].images.resize(images);
    }
    std::atomic<std::size_t> next = 0;
    std::mutex mutex;
    absl::Status status;
    const auto work = [&] {
      for (std::size_t i = next++; i < tasks.size(); i = next++) {
        const std::uint32_t begin = begin_of(tasks[i].image, spp_, plan_.job.spp);
        absl::StatusOr<PilotImage> image = stop_.stop_requested()
                                               ? absl::CancelledError("interrupted")
                                               : renderer_.render(entry_of_[tasks[i].candidate], begin,
                                                                  begin + spp_, kFirstSeed + tasks[i].image);
        const std::lock_guard lock{mutex};
        if (!image.ok()) {
          status.Update(image.status());
          return;
        }
        candidates_[tasks[i].candidate].images[tasks[i].image] = *std::move(image);
      }
    };
    {
      std::vector<std::jthread> helpers;
      for (int i = 1; i < plan_.threads; ++i) helpers.emplace_back(work);
      work();
    }
    done_ = images;
    return status;
  }

  PilotOutcome::Entry& entry(std::size_t candidate) { return outcome_.entries[entry_of_[candidate]]; }

  void judge_all() {
    const std::vector<Judgement> judgements = judge(candidates_, outcome_.frame, plan_.job);
    const auto ahead = [&](std::size_t a, std::size_t b) {
      return std::log(judgements[a].efficiency() / judgements[b].efficiency());
    };
    // One that has the most ways is not suspect, and there is one.
    std::size_t best = judgements.size();
    for (std::size_t c = 0; c < judgements.size(); ++c) {
      if (judgements[c].eligible() && (best == judgements.size() || ahead(c, best) > 0)) best = c;
    }
    outcome_.judged = true;
    outcome_.best = entry_of_[best];
    outcome_.is_clear = true;
    for (std::size_t c = 0; c < judgements.size(); ++c) {
      PilotOutcome::Entry& own = entry(c);
      own.judgement = judgements[c];
      own.images = static_cast<std::uint32_t>(candidates_[c].images.size());
      own.samples = spp_;
      costs_[entry_of_[c]] = judgements[c].cpu_seconds / plan_.job.pixels() / plan_.job.spp;
      if (c == best) continue;
      const double error = std::hypot(judgements[best].uncertainty, judgements[c].uncertainty);
      const bool worse = !judgements[c].eligible() || ahead(best, c) > kClear * error;
      outcome_.is_clear = outcome_.is_clear && worse;
      // Who has more ways may yet show what a doubted one lacks.
      const bool is_witness = judgements[best].is_doubted && candidates_[c].ways > candidates_[best].ways;
      own.dropped = own.dropped || (worse && !is_witness && done_ >= kUsualImages);
    }
  }

  const std::span<const PilotEntry> entries_;
  const PilotPlan& plan_;
  PilotRenderer& renderer_;
  const std::stop_token stop_;
  std::vector<PilotCandidate> candidates_;  // without those that cannot render the scene
  std::vector<std::size_t> entry_of_;       // each candidate's
  std::vector<double> costs_;               // CPU seconds of a sample of a pixel; 0: not known
  double first_build_seconds_ = 0;
  absl::Status first_refusal_;
  bool is_asked_ = false;   // who finds all of the light
  std::uint32_t spp_ = 1;   // samples per pixel of a picture
  std::uint32_t done_ = 0;  // images of each candidate that is not dropped
  PilotOutcome outcome_;
};

}  // namespace

absl::StatusOr<PilotOutcome> run_pilot(std::span<const PilotEntry> candidates, const PilotPlan& plan,
                                       PilotRenderer& renderer, std::stop_token stop) {
  return Pilot(candidates, plan, renderer, std::move(stop)).run();
}

}  // namespace tessera::client
