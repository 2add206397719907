// One dishonest certificate tries all that it can do to a farm: take over jobs by what it claims, darken
// pictures, and have users pay for it. The worlds below are the scheduler alone, with time that is made up.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "scenario/scenario_runner.h"
#include "scenario/seeds.h"
#include "scheduler/identity.h"
#include "scheduler/scheduler.h"
#include "support/long_form.h"

namespace tessera::server {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr char kHonestClass[] = "avx2/e3/aa", kInvented[] = "avx512/e3/invented";

/// The host of the holder of a key of its own.
std::string host_of(std::size_t identity) {
  const std::string digits = absl::StrCat(identity);
  return absl::StrCat("h", identity, "@", std::string(32 - digits.size(), 'a'), digits);
}

WorkerInfo machine(const std::string& id, std::size_t identity,
                   std::vector<std::string> classes = {kHonestClass}, std::uint32_t threads = 2) {
  return {.id = id,
          .name = id,
          .build = "",
          .isa = "avx2",
          .supported_isas = {"avx2"},
          .threads = threads,
          .host = host_of(identity),
          .tags = {},
          .classes = std::move(classes)};
}

JobRequest job_of(const std::string& id, std::uint32_t units, const std::string& user = "") {
  return {.id = id,
          .plan = row_of_tiles(units, 1),
          .scene_digest = "s",
          .isa = "",
          .user = user,
          .required_tags = {}};
}

std::vector<v1::Lease> lease(Scheduler& scheduler, const std::string& worker, std::uint32_t units, Time now) {
  const auto decision = scheduler.lease({.worker = worker, .max_units = units, .loaded_scenes = {}}, now);
  return decision.ok() ? decision->leases : std::vector<v1::Lease>{};
}

// ---------------------------------------------------------------- classes

class Takeover : public testing::Test {
 protected:
  Scheduler scheduler_{{.audit_key = "key"}};
};

TEST_F(Takeover, IsNotHadByClaims) {
  ASSERT_TRUE(scheduler_.add_job(job_of("a", 256)).ok());
  // All at once from the liar: threads, an invented class, many workers, and the honest class as well.
  for (const char* const worker : {"liar", "liar2", "liar3"})
    ASSERT_TRUE(scheduler_.register_worker(machine(worker, 0, {kInvented, kHonestClass}, ~0u), Time{0}).ok());
  ASSERT_TRUE(scheduler_.register_worker(machine("one", 1), Time{0}).ok());
  ASSERT_TRUE(scheduler_.register_worker(machine("two", 2), Time{0}).ok());
  EXPECT_THAT(lease(scheduler_, "one", 1, Time{0}), testing::SizeIs(1));
  EXPECT_THAT(scheduler_.job("a")->classes, testing::ElementsAre(kHonestClass));
}

TEST_F(Takeover, IsNotHadByThreadsOfAClassThatWasConfirmedOnce) {
  // Two machines of each of two classes have confirmed each other's results; then one of the one class stays,
  // and says that it has a thousand threads.
  for (std::size_t i = 0; i < 4; ++i) {
    const std::string name = i < 2 ? kHonestClass : kInvented;
    FarmEvent confirmed{
        .kind = FarmEvent::Kind::kClassConfirmed, .job = "", .host = identity_of(host_of(i)), .text = name};
    ASSERT_TRUE(scheduler_.restore(confirmed).ok()) << "as after a restart";
  }
  ASSERT_TRUE(scheduler_.register_worker(machine("one", 0), Time{0}).ok());
  ASSERT_TRUE(scheduler_.register_worker(machine("two", 1), Time{0}).ok());
  ASSERT_TRUE(scheduler_.register_worker(machine("liar", 2, {kInvented}, 1000), Time{0}).ok());
  ASSERT_TRUE(scheduler_.add_job(job_of("a", 8)).ok());
  EXPECT_THAT(lease(scheduler_, "liar", 8, Time{0}), IsEmpty());
  // With the second one it is a class again, and the larger.
  ASSERT_TRUE(scheduler_.register_worker(machine("other", 3, {kInvented}, 2), Time{0}).ok());
  EXPECT_THAT(lease(scheduler_, "one", 1, Time{0}), IsEmpty());
  EXPECT_THAT(lease(scheduler_, "other", 1, Time{0}), testing::SizeIs(1));
}

TEST_F(Takeover, EndsWhenTheClassHasDiedOut) {
  ASSERT_TRUE(scheduler_.add_job(job_of("a", 256)).ok());
  ASSERT_TRUE(scheduler_.register_worker(machine("liar", 0, {kInvented}), Time{0}).ok());
  ASSERT_THAT(lease(scheduler_, "liar", 1, Time{0}), testing::SizeIs(1));
  ASSERT_TRUE(scheduler_.register_worker(machine("one", 1), Time{0}).ok());
  ASSERT_TRUE(scheduler_.deregister_worker("liar").ok());
  EXPECT_THAT(lease(scheduler_, "one", 1, Time{0}), IsEmpty());
  for (Time now{0}; now <= Time{10'000}; now += Time{1000}) {
    lease(scheduler_, "one", 0, now);
    scheduler_.advance(now);
  }
  EXPECT_THAT(lease(scheduler_, "one", 1, Time{10'000}), testing::SizeIs(1));
  EXPECT_THAT(scheduler_.job("a")->classes, testing::ElementsAre(kHonestClass));
}

TEST_F(Takeover, MakesAJobsResultsAnewAfterALongWhile) {
  ASSERT_TRUE(scheduler_.add_job(job_of("a", 4)).ok());
  ASSERT_TRUE(scheduler_.register_worker(machine("gone", 0, {kInvented}), Time{0}).ok());
  const std::vector<v1::Lease> granted = lease(scheduler_, "gone", 1, Time{0});
  ASSERT_TRUE(scheduler_.complete("gone", granted.at(0).token(), {.fingerprint = 7}, Time{1}).ok());
  ASSERT_TRUE(scheduler_.register_worker(machine("one", 1), Time{1}).ok());
  ASSERT_TRUE(scheduler_.deregister_worker("gone").ok());
  const Time patience = SchedulerOptions{}.class_patience;
  scheduler_.advance(Time{1});
  lease(scheduler_, "one", 0, patience);
  scheduler_.advance(patience);
  EXPECT_EQ(scheduler_.job("a")->units_done, 1u) << "it may come back";
  lease(scheduler_, "one", 0, patience + Time{1});
  scheduler_.advance(patience + Time{1});
  EXPECT_EQ(scheduler_.job("a")->units_done, 0u) << "results of a job are of one class";
  EXPECT_THAT(scheduler_.job("a")->notes, testing::ElementsAre(HasSubstr("1 units are done again")));
  EXPECT_THAT(lease(scheduler_, "one", 8, patience + Time{1}), testing::Not(IsEmpty()));
  EXPECT_THAT(scheduler_.job("a")->classes, testing::ElementsAre(kHonestClass));
}

TEST_F(Takeover, IsNoWayToKeepJobsFromBeginning) {
  Scheduler scheduler({.settle = Time{1000}});
  ASSERT_TRUE(scheduler.add_job(job_of("a", 4)).ok());
  ASSERT_TRUE(scheduler.register_worker(machine("one", 1), Time{0}).ok());
  ASSERT_TRUE(scheduler.register_worker(machine("two", 2), Time{0}).ok());
  std::size_t leases = 0;
  for (Time now{0}; now < Time{20'000}; now += Time{500}) {  // ever new kinds of machines
    const std::string id = absl::StrCat("liar", now.count());
    ASSERT_TRUE(scheduler.register_worker(machine(id, 0, {absl::StrCat("avx2/e3/", now.count())}), now).ok());
    leases += lease(scheduler, "one", 1, now).size();
  }
  EXPECT_EQ(leases, 4u);
}

// ---------------------------------------------------------------- costs

/// A farm of four machines whose units take 10 ms, and a fifth that has had three of Alice's for a second.
class Costs : public testing::Test {
 protected:
  Costs() {
    EXPECT_TRUE(scheduler_.add_job(job_of("alice", 4096, "alice")).ok());
    EXPECT_TRUE(scheduler_.add_job(job_of("bob", 4096, "bob")).ok());
    for (std::size_t i = 0; i < 5; ++i)
      EXPECT_TRUE(scheduler_.register_worker(machine(name(i), i, {kHonestClass}, 1), now_).ok());
  }

  static std::string name(std::size_t i) { return absl::StrCat("w", i); }

  /// Units take 10 ms and trace a thousand rays. A liar says of Alice's that it has traced far more, and of
  /// Bob's that they took far less: both make it as fast, so that hers seem to be the larger ones.
  DeliveredResult result_of(std::size_t worker, const std::string& job) const {
    DeliveredResult result{.fingerprint = 1, .cost = std::chrono::milliseconds{10}, .work = 1000};
    constexpr std::int64_t kTooFast = 10'000'000;
    if (!first_lies_ || worker != 1) return result;
    if (job == "alice") {
      result.work *= kTooFast;
    } else {
      result.cost /= kTooFast;
    }
    return result;
  }

  void work(Time time) {
    for (const Time end = now_ + time; now_ < end; now_ += Time{10}) {
      for (std::size_t i = 1; i < 5; ++i) {
        for (const v1::Lease& one : held_[i]) {
          EXPECT_TRUE(
              scheduler_.complete(name(i), one.token(), result_of(i, one.token().job_id()), now_).ok());
          ++done_[one.token().job_id()];
          ++done_by_[name(i)];
          if (i == 1 && one.token().job_id() == "bob") ++of_bob_by_first_;
        }
        held_[i] = lease(scheduler_, name(i), 1, now_);
      }
    }
  }

  /// Units of each user that are done in the two seconds after the three are returned at this cost.
  void work_after(std::chrono::nanoseconds cost) {
    work(Time{2000});
    std::vector<v1::Lease> of_alice;
    while (of_alice.size() < 3) {
      for (v1::Lease& one : lease(scheduler_, name(0), 1, now_)) {
        if (one.token().job_id() == "alice") {
          of_alice.push_back(std::move(one));
        } else {
          EXPECT_TRUE(scheduler_.complete(name(0), one.token(), {.fingerprint = 1}, now_).ok());
        }
      }
    }
    work(Time{1000});
    for (const v1::Lease& one : of_alice)
      EXPECT_TRUE(scheduler_.complete(name(0), one.token(), {.fingerprint = 1, .cost = cost}, now_).ok());
    done_.clear(), done_by_.clear(), of_bob_by_first_ = 0;
    work(Time{2000});
  }

  Scheduler scheduler_{{.lease_timeout = std::chrono::hours{1}, .longest_run = Time{0}, .audit_one_in = 0}};
  std::map<std::size_t, std::vector<v1::Lease>> held_;
  std::map<std::string, int> done_, done_by_;
  int of_bob_by_first_ = 0;
  bool first_lies_ = false;
  Time now_{0};
};

TEST_F(Costs, AreSharedByUsers) {
  work_after(std::chrono::milliseconds{10});
  EXPECT_NEAR(done_["alice"], done_["bob"], 8) << "two leases of each machine";
}

TEST_F(Costs, OfOneLiarDoNotTakeTheFarmFromAUser) {
  work_after(std::chrono::nanoseconds::max());
  // Three results raise the mean by no more than 29 eighths of a unit each (Runs::kMostSpread), and what is
  // too much goes down by an eighth with each of Alice's results: together she is charged for 3 * 29 units
  // more, which Bob gets.
  EXPECT_NEAR(done_["alice"], done_["bob"], 3 * 29 + 8);
}

TEST_F(Costs, OfWhoSeemsFastDoNotTakeTheFarmFromAUser) {
  first_lies_ = true;
  work_after(std::chrono::milliseconds{10});
  // The liar's results may count as nothing for Bob; all others count in full.
  const double counted = 1 - static_cast<double>(of_bob_by_first_) / done_["bob"];
  EXPECT_LE(done_["bob"] * counted, done_["alice"] + 8);
  EXPECT_GT(counted, 0.5);
  EXPECT_LE(done_["alice"], done_["bob"] + 8);
  for (std::size_t i = 2; i < 5; ++i)
    EXPECT_GT(done_by_[name(i)], done_by_[name(1)] / 2) << "who is honest has as much to do: " << name(i);
}

// ---------------------------------------------------------------- pictures

enum class Lie {
  kBlackAtOnce,    // everything, without rendering
  kBlackLater,     // everything but the first ten results, at the pace of the others
  kHalvesLater,    // the same, and half of each tile is right
  kFewBlackUnits,  // three of a picture
  kFewPixels,      // three of a picture, and of these only what one spot in sixteen has
};

struct World {
  std::uint32_t identities = 3, liars = 1;
  Lie lie = Lie::kBlackAtOnce;
  double spot_share = 1.0 / 16;
  std::uint64_t seed = 0;
};

struct Outcome {
  bool ended = false, marked = false, honest_barred = false;
  std::uint32_t wrong = 0;  // units of the picture
  double extra = 0;         // work that was asked for beyond the picture, of the picture's
};

constexpr std::uint32_t kUnits = 256, kSpots = 16;

class Play {
 public:
  explicit Play(const World& world)
      : world_(world),
        random_(world.seed),
        scheduler_({.lease_timeout = std::chrono::hours{100},
                    .longest_run = Time{0},
                    .audit_key = absl::StrCat(world.seed)}),
        hands_(world.identities) {
    static const std::shared_ptr<const WorkPlan> plan = row_of_tiles(kUnits, 1);
    EXPECT_TRUE(
        scheduler_
            .add_job(
                {.id = "a", .plan = plan, .scene_digest = "s", .isa = "", .user = "", .required_tags = {}})
            .ok());
    for (std::uint32_t i = 0; i < world.identities; ++i)
      EXPECT_TRUE(scheduler_.register_worker(machine(name(i), i, {kHonestClass}, 1), Time{0}).ok());
  }

  Outcome run() {
    for (std::uint64_t step = 0; step < 100 * kUnits; ++step) {
      const auto next = std::min_element(hands_.begin(), hands_.end(),
                                         [](const Hand& a, const Hand& b) { return a.free_at < b.free_at; });
      now_ = next->free_at;
      act(static_cast<std::uint32_t>(next - hands_.begin()), *next);
      if (step % 64 == 0) scheduler_.advance(now_);
      learn();
      if (scheduler_.job("a")->state == v1::DONE) break;
    }
    const JobView view = *scheduler_.job("a");
    outcome_.ended = view.state == v1::DONE;
    outcome_.marked = !view.notes.empty() || view.units_unconfirmed > 0;
    for (const auto& [unit, bad] : accepted_) outcome_.wrong += bad;
    return outcome_;
  }

 private:
  struct Hand {
    Time free_at{};
    std::optional<v1::Lease> lease;
    std::uint32_t results = 0;
  };

  static std::string name(std::uint32_t i) { return absl::StrCat("w", i); }
  bool is_liar(std::uint32_t worker) const { return worker < world_.liars; }
  bool chance(double p) { return static_cast<double>(random_() >> 11) < p * 9007199254740992.0; }

  /// Whether this worker's own result of a unit is to be wrong.
  bool lies(std::uint32_t worker, const Hand& hand) {
    if (!is_liar(worker)) return false;
    switch (world_.lie) {
      case Lie::kBlackAtOnce:
        return true;
      case Lie::kBlackLater:
      case Lie::kHalvesLater:
        return hand.results >= 10;
      default:
        return chance(3.0 / kUnits * world_.identities);
    }
  }

  bool is_wrong(std::uint32_t spot) const {
    return world_.lie == Lie::kHalvesLater ? spot <= kSpots / 2
           : world_.lie == Lie::kFewPixels ? spot == 1
                                           : true;
  }

  static ResultFingerprint truth(std::uint32_t unit, std::uint32_t spot) {
    return 1000 * (unit + 1) + 2 * spot;
  }

  void act(std::uint32_t worker, Hand& hand) {
    if (hand.lease) deliver(worker, hand, *hand.lease);
    hand.lease.reset();
    for (v1::Lease& one : lease(scheduler_, name(worker), 1, now_)) hand.lease = std::move(one);
    // Units cost alike, within a tenth.
    const bool at_once = is_liar(worker) && world_.lie == Lie::kBlackAtOnce;
    const double part = hand.lease && hand.lease->token().spot() != 0 ? world_.spot_share : 1;
    hand.free_at = now_ + (!hand.lease ? Time{100}
                           : at_once   ? Time{1}
                                       : Time(static_cast<std::int64_t>(part * (1000 + random_() % 100))));
  }

  void deliver(std::uint32_t worker, Hand& hand, const v1::Lease& leased) {
    const std::uint32_t unit = leased.token().unit_index(), spot = leased.token().spot();
    const auto done = accepted_.find(unit);
    // Those who conspire say of each other's what they said, and do not render it.
    const bool again = done != accepted_.end();
    const bool wrong = again ? is_liar(worker) && done->second : lies(worker, hand);
    if (again) outcome_.extra += (spot != 0 ? world_.spot_share : 1) / kUnits;
    const auto lie = static_cast<ResultFingerprint>(wrong);
    const std::uint32_t own = 1 + static_cast<std::uint32_t>(random_() % kSpots);
    const DeliveredResult result{.fingerprint = truth(unit, spot) + (spot == 0 || is_wrong(spot) ? lie : 0),
                                 .cost = {},
                                 .spot = {.number = own,
                                          .fingerprint = truth(unit, own) + (is_wrong(own) ? lie : 0),
                                          .share = world_.spot_share}};
    const auto decision = scheduler_.complete(name(worker), leased.token(), result, now_);
    if (!decision.ok() || decision->duplicate) return;
    ++hand.results;
    accepted_[unit] = wrong;
  }

  void learn() {
    for (const FarmEvent& event : scheduler_.take_events()) {
      if (event.kind == FarmEvent::Kind::kRevoked) accepted_.erase(event.unit);
      if (event.kind != FarmEvent::Kind::kDistrusted) continue;
      for (std::uint32_t i = world_.liars; i < world_.identities; ++i)
        outcome_.honest_barred |= identity_of(host_of(i)) == event.host;
    }
  }

  const World world_;
  std::mt19937_64 random_;
  Scheduler scheduler_;
  std::vector<Hand> hands_;
  std::map<std::uint32_t, bool> accepted_;  // units that are done, and whether wrongly
  Time now_{0};
  Outcome outcome_;
};

struct Tally {
  std::uint64_t worlds = 0, unmarked = 0;
  double wrong = 0, extra = 0;  // units of those pictures, and work, on average
};

Tally tally(World world, std::uint64_t worlds) {
  Tally sum{.worlds = worlds};
  const std::uint64_t first = number_from("TESSERA_FIRST_SEED", 1);
  for (world.seed = first; world.seed < first + worlds; ++world.seed) {
    const Outcome outcome = Play(world).run();
    EXPECT_TRUE(outcome.ended) << "seed " << world.seed;
    EXPECT_FALSE(outcome.honest_barred) << "seed " << world.seed;
    sum.extra += outcome.extra / static_cast<double>(worlds);
    if (outcome.wrong == 0 || outcome.marked) continue;
    ++sum.unmarked;
    sum.wrong += outcome.wrong;
    if (testing::Test::HasFailure()) break;
  }
  if (sum.unmarked > 0) sum.wrong /= static_cast<double>(sum.unmarked);
  std::printf(
      "%u of %u dishonest, lie %d, spots of %.4f: %llu of %llu pictures wrong and unmarked (%.1f units), "
      "%.2f %% more work\n",
      world.liars, world.identities, static_cast<int>(world.lie), world.spot_share,
      static_cast<unsigned long long>(sum.unmarked), static_cast<unsigned long long>(worlds), sum.wrong,
      100 * sum.extra);
  return sum;
}

/// Worlds of the case that the promise is about; and of each of the others.
std::uint64_t many_worlds() { return test::how_often("TESSERA_WORLDS", 500, 1'000'000); }
std::uint64_t worlds() { return test::how_often("TESSERA_WORLDS", 500, 20'000); }

// Tiles of 32 pixels, whose spots are a sixteenth; and of 128 with a border of 4, where every result is
// looked at.
constexpr double kSmallTiles = 1.0 / 16, kLargeTiles = 0.0139;

TEST(Picture, OfAnHonestFarmCostsLessThanThreePerCentMore) {
  for (const double share : {kSmallTiles, kLargeTiles}) {
    const Tally honest = tally({.identities = 3, .liars = 0, .spot_share = share}, 50);
    EXPECT_LT(honest.extra, 0.03);
  }
}

// One test for each way to lie, so that one of them can be played for as long as there is time:
// TESSERA_WORLDS=50000 TESSERA_FIRST_SEED=1 scenario_tests --gtest_filter=Picture.*OneOfThreeAtOnce
TEST(Picture, IsNotDarkenedByOneOfThreeAtOnce) {
  EXPECT_EQ(tally({.lie = Lie::kBlackAtOnce, .spot_share = kSmallTiles}, many_worlds()).unmarked, 0u);
}

TEST(Picture, IsNotDarkenedByOneOfThreeLater) {
  EXPECT_EQ(tally({.lie = Lie::kBlackLater, .spot_share = kSmallTiles}, many_worlds()).unmarked, 0u);
}

TEST(Picture, IsNotDarkenedByOneOfThree) {
  EXPECT_EQ(tally({.lie = Lie::kHalvesLater, .spot_share = kSmallTiles}, worlds()).unmarked, 0u);
  for (const Lie lie : {Lie::kBlackAtOnce, Lie::kBlackLater, Lie::kHalvesLater})
    EXPECT_EQ(tally({.lie = lie, .spot_share = kLargeTiles}, worlds()).unmarked, 0u);
}

TEST(Picture, IsNotDarkenedByOneOfTwoUnmarked) {
  EXPECT_EQ(tally({.identities = 2, .lie = Lie::kBlackLater}, worlds()).unmarked, 0u);
}

TEST(Picture, IsNotDarkenedByTwoOfFiveWhoConspire) {
  for (const Lie lie : {Lie::kBlackAtOnce, Lie::kBlackLater})
    EXPECT_EQ(tally({.identities = 5, .liars = 2, .lie = lie}, worlds()).unmarked, 0u);
}

TEST(Picture, IsNotDarkenedByOneOfFive) {
  EXPECT_EQ(tally({.identities = 5, .lie = Lie::kBlackLater}, worlds()).unmarked, 0u);
}

// Chance may miss one bad unit of hundreds, or a few pixels of it. The figures are in
// docs/decisions/0009-scheduling.md.
TEST(Picture, MayHaveAFewWrongUnits) {
  // Each unit that is black is looked at, but for those that nobody looks at: with large tiles, none.
  EXPECT_EQ(tally({.lie = Lie::kFewBlackUnits, .spot_share = kLargeTiles}, worlds()).unmarked, 0u);
  const Tally small = tally({.lie = Lie::kFewBlackUnits, .spot_share = kSmallTiles}, worlds());
  // All of n black ones are missed with probability (1 - p)^n, n being binomial with a mean of 3.
  const double p = 1 - (1 - SchedulerOptions{}.spot_work / kSmallTiles) * 0.99;
  const double expected = std::exp(-3 * p) - std::exp(-3.0);
  const double deviation = std::sqrt(expected * (1 - expected) / static_cast<double>(small.worlds));
  EXPECT_NEAR(static_cast<double>(small.unmarked) / static_cast<double>(small.worlds), expected,
              5 * deviation + 0.02);
  tally({.lie = Lie::kFewPixels, .spot_share = kLargeTiles}, worlds());
}

}  // namespace
}  // namespace tessera::server
