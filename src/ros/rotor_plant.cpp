#include "amb_rotor/ros/rotor_plant.hpp"

#include <rosgraph_msgs/Clock.h>
#include <unistd.h>

#include "amb_rotor/ros/conversions.hpp"
#include "amb_rotor/ros/node_setup.hpp"

namespace amb_rotor {
namespace {

constexpr double watch_period_s = 0.02;  // of the wall
constexpr double status_period_s = 0.5;  // of the wall
constexpr double least_pause_s = 1e-3;   // of the wall: shorter waits are made up for later

/// Different for each start of a plant; it has no influence on the motion.
std::uint64_t newRun() {
  return ros::WallTime::now().toNSec() ^ (static_cast<std::uint64_t>(getpid()) << 48);
}

bool wellFormed(const ControlCommand& answer) { return answer.controller_memory.size() == 4; }
bool wellFormed(const ContactForces& answer) { return answer.ends.size() == 2; }
bool wellFormed(const Injection&) { return true; }

}  // namespace

RotorPlant::RotorPlant(const ros::NodeHandle& nodes, const ros::NodeHandle& own)
    : nodes_(nodes),
      core_(modelOf(own), scenarioOf(own), newRun()),
      rate_(numberOr(own, "rate", 1.0)),
      clock_offset_(numberOr(own, "clock_offset", 1.0)),
      clock_period_(numberOr(own, "clock_period", 1e-3)),
      repeat_after_(numberOr(own, "repeat_after", 0.2)),
      alarm_after_(numberOr(own, "alarm_after", 1.0)),
      linger_(numberOr(own, "linger", 1.0)),
      listeners_(integerOr(own, "listeners", 3)),
      wait_for_(wordsOf(own, "wait_for")),
      exit_at_end_(switchOr(own, "exit_at_end", true)),
      updater_(nodes_, own, own.getNamespace()) {
  state_publisher_ = nodes_.advertise<RotorState>("rotor/state", keep_all);
  model_publisher_ = nodes_.advertise<ModelInfo>("rotor/model", 1, true);
  status_publisher_ = nodes_.advertise<PlantStatus>("rotor/status", 10, true);
  tacho_publisher_ = nodes_.advertise<Tacho>("rotor/tacho", keep_all);
  clock_publisher_ = nodes_.advertise<rosgraph_msgs::Clock>("/clock", 10);

  ModelInfo info = core_.info();
  info.header.stamp = stamp(0.0);
  info.clock_offset = clock_offset_;
  model_publisher_.publish(info);
  status_.run = info.run;

  control_subscriber_ = nodes_.subscribe<ControlCommand>(
      "controller/command", keep_all, [this](const Slot<ControlCommand>& m) { take(m, control_); }, nullptr,
      noDelay());
  contact_subscriber_ = nodes_.subscribe<ContactForces>(
      "auxiliary_bearing/contact", keep_all, [this](const Slot<ContactForces>& m) { take(m, contact_); },
      nullptr, noDelay());
  injection_subscriber_ = nodes_.subscribe<Injection>(
      "injector/injection", keep_all, [this](const Slot<Injection>& m) { take(m, injection_); }, nullptr,
      noDelay());

  updater_.setHardwareID("simulation");
  updater_.add("lock-step", this, &RotorPlant::diagnose);
  last_progress_ = ros::WallTime::now();
  publishClock(true);
  publishStatus();
  watch_timer_ = nodes_.createWallTimer(ros::WallDuration(watch_period_s),
                                        [this](const ros::WallTimerEvent&) { watch(); });
}

template <class Answer>
void RotorPlant::take(const Slot<Answer>& answer, Slot<Answer>& slot) {
  const RotorState& now = core_.state();
  if (answer->run != now.run || answer->model_hash != now.model_hash || answer->step > now.step ||
      !wellFormed(*answer)) {
    ++status_.foreign_answers;
    return;
  }
  if (answer->step < now.step) {
    ++status_.late_answers;
    return;
  }
  if (slot != nullptr) {
    ++status_.repeated_answers;
    return;
  }
  slot = answer;
  if (published_ == nullptr || ended_ || control_ == nullptr || contact_ == nullptr || injection_ == nullptr)
    return;
  last_progress_ = ros::WallTime::now();
  if (now.step == 0) first_answer_ = last_progress_;
  if (core_.finished())
    end(PlantStatus::FINISHED);
  else
    step();
}

void RotorPlant::step() {
  const bool going = core_.advance(*control_, *contact_, *injection_);
  control_.reset();
  contact_.reset();
  injection_.reset();
  for (Tacho pulse : core_.pulses()) {
    pulse.header.frame_id = stator_frame;
    pulse.header.stamp = stamp(core_.state().time);
    tacho_publisher_.publish(pulse);
  }
  if (!going) {
    end(core_.diverged() ? PlantStatus::DIVERGED : PlantStatus::FAILED);
    return;
  }
  pace();
}

void RotorPlant::pace() {
  if (rate_ > 0.0) {
    const ros::WallTime due = first_answer_ + ros::WallDuration(core_.state().time / rate_);
    const ros::WallDuration pause = due - ros::WallTime::now();
    if (pause.toSec() > least_pause_s) {
      published_.reset();
      pace_timer_ = nodes_.createWallTimer(
          pause, [this](const ros::WallTimerEvent&) { publishState(); }, true);
      return;
    }
  }
  publishState();
}

void RotorPlant::publishState() {
  auto message = boost::make_shared<RotorState>(core_.state());
  message->header.stamp = stamp(message->time);
  published_ = message;
  publishClock(core_.finished());
  last_publication_ = ros::WallTime::now();
  state_publisher_.publish(published_);
}

void RotorPlant::publishClock(bool always) {
  const double time = core_.state().time;
  if (!always && time < last_clock_ + clock_period_ - instant_tolerance_s) return;
  last_clock_ = time;
  rosgraph_msgs::Clock clock;
  clock.clock = stamp(time);
  clock_publisher_.publish(clock);
}

/// Nodelets of our own process count as one listener; whether they are there is told by what they publish.
bool RotorPlant::everybodyListens() const {
  return static_cast<int>(state_publisher_.getNumSubscribers()) >= listeners_ &&
         areAdvertised(nodes_, wait_for_);
}

/// Looks at the wall's clock: simulated time may stand still.
void RotorPlant::watch() {
  const ros::WallTime now = ros::WallTime::now();
  if (ended_) {
    if (exit_at_end_ && (now - end_).toSec() > linger_) ros::requestShutdown();
  } else if (published_ == nullptr) {
    if (core_.state().step == 0 && everybodyListens()) publishState();
  } else if ((now - std::max(last_progress_, last_publication_)).toSec() > repeat_after_) {
    ++status_.repeated_steps;
    last_publication_ = now;
    state_publisher_.publish(published_);
  }
  if ((now - last_status_).toSec() > status_period_s) {
    last_status_ = now;
    publishStatus();
    updater_.force_update();
  }
}

void RotorPlant::end(std::uint8_t state) {
  ended_ = true;
  end_ = ros::WallTime::now();
  status_.state = state;
  status_.reason = core_.reason();
  publishClock(true);
  publishStatus();
  updater_.force_update();
  if (state == PlantStatus::FINISHED)
    ROS_INFO("rotor_plant: %.6g s simulated in %llu steps and %.3g s", core_.state().time,
             static_cast<unsigned long long>(core_.state().step), (end_ - first_answer_).toSec());
  else
    ROS_ERROR("rotor_plant: ended at %.6g s: %s", core_.state().time, core_.reason().c_str());
}

void RotorPlant::publishStatus() {
  const RotorState& now = core_.state();
  status_.header.frame_id = stator_frame;
  status_.header.stamp = stamp(now.time);
  status_.step = now.step;
  status_.time = now.time;
  status_.wall_time =
      first_answer_.isZero() ? 0.0 : ((ended_ ? end_ : ros::WallTime::now()) - first_answer_).toSec();
  status_publisher_.publish(status_);
}

void RotorPlant::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  std::string missing;
  if (control_ == nullptr) missing += " amb_controller";
  if (contact_ == nullptr) missing += " auxiliary_bearing";
  if (injection_ == nullptr) missing += " injector";
  const double silence = (ros::WallTime::now() - last_progress_).toSec();
  using Level = diagnostic_msgs::DiagnosticStatus;
  if (status_.state == PlantStatus::DIVERGED || status_.state == PlantStatus::FAILED)
    status.summary(Level::ERROR, "ended: " + core_.reason());
  else if (ended_)
    status.summary(Level::OK, "finished");
  else if (published_ != nullptr && silence > alarm_after_ && !missing.empty())
    status.summaryf(Level::ERROR, "simulated time stands still: no answer for %.1f s from%s", silence,
                    missing.c_str());
  else if (status_.foreign_answers > 0)
    status.summaryf(Level::WARN, "%llu foreign answers dropped",
                    static_cast<unsigned long long>(status_.foreign_answers));
  else
    status.summary(Level::OK, "running");
  status.add("step", core_.state().step);
  status.add("simulated time [s]", core_.state().time);
  status.add("late answers", status_.late_answers);
  status.add("foreign answers", status_.foreign_answers);
  status.add("repeated answers", status_.repeated_answers);
  status.add("repeated steps", status_.repeated_steps);
}

}  // namespace amb_rotor
