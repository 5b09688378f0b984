#include "amb_rotor/ros/recorder.hpp"

#include <ros/callback_queue.h>
#include <rosgraph_msgs/Clock.h>

#include <csignal>
#include <cstdio>

#include "amb_rotor/ros/messages.hpp"
#include "amb_rotor/ros/node_setup.hpp"

namespace amb_rotor {
namespace {

constexpr double silence_s = 0.5;  // of the wall: nothing more is on its way
constexpr double spin_period_s = 0.05;

volatile std::sig_atomic_t asked_to_end = 0;

template <class Message>
ros::Time stampOf(const Message& message, const ros::Time&) {
  return message.header.stamp;
}
ros::Time stampOf(const rosgraph_msgs::Clock& message, const ros::Time&) { return message.clock; }
ros::Time stampOf(const FaultMessage&, const ros::Time& last) { return last; }  // a person's: has no stamp

}  // namespace

Recorder::Recorder(const ros::NodeHandle& nodes, const ros::NodeHandle& own)
    : nodes_(nodes),
      path_(requiredText(own, "bag")),
      exit_at_end_(switchOr(own, "exit_at_end", false)),
      last_(ros::WallTime::now()),
      last_stamp_(ros::TIME_MIN) {
  part_ = path_ + ".part";
  try {
    bag_.open(part_, rosbag::bagmode::Write);
  } catch (const rosbag::BagException& error) {
    throw InputError({{part_, 0, "", "", error.what()}});
  }
  record<ModelInfo>("rotor/model");
  record<PlantStatus>("rotor/status");
  record<Tacho>("rotor/tacho");
  record<ControlCommand>("controller/command");
  record<ContactForces>("auxiliary_bearing/contact");
  record<Injection>("injector/injection");
  record<FaultMessage>("fault");
  record<OrbitAnalysis>("analysis/orbit");
  record<SectionPoint>("analysis/poincare");
  record<FullSpectrum>("analysis/spectrum");
  record<rosgraph_msgs::Clock>("/clock");
  record<RotorState>("rotor/state");  // last: a plant that has this listener has all of us
}

Recorder::~Recorder() { close(); }

template <class Message>
void Recorder::record(const std::string& topic) {
  const std::string name = nodes_.resolveName(topic);
  ros::SubscribeOptions options;
  options.initByFullCallbackType<const ros::MessageEvent<Message const>&>(
      name, keep_all,
      [this, name](const ros::MessageEvent<Message const>& event) { write<Message>(name, event); });
  options.transport_hints = noDelay();
  subscribers_.push_back(nodes_.subscribe(options));
}

template <class Message>
void Recorder::write(const std::string& topic, const ros::MessageEvent<Message const>& event) {
  if (closed_) return;
  last_ = ros::WallTime::now();
  const ros::Time stamp = std::max(stampOf(*event.getConstMessage(), last_stamp_), ros::TIME_MIN);
  last_stamp_ = std::max(last_stamp_, stamp);
  bag_.write(topic, stamp, *event.getConstMessage(), event.getConnectionHeaderPtr());
  if constexpr (std::is_same_v<Message, PlantStatus>)
    ended_ = event.getConstMessage()->state != PlantStatus::RUNNING;
}

bool Recorder::complete() const { return ended_ && silence() > silence_s; }

void Recorder::close() {
  if (closed_) return;
  closed_ = true;
  bag_.close();
  if (std::rename(part_.c_str(), path_.c_str()) != 0) ROS_ERROR("recorder: cannot write %s", path_.c_str());
}

int runRecorder(int argc, char** argv) {
  ros::init(argc, argv, "recorder", ros::init_options::NoSigintHandler);
  std::signal(SIGINT, [](int) { asked_to_end = 1; });
  std::signal(SIGTERM, [](int) { asked_to_end = 1; });
  try {
    Recorder recorder{ros::NodeHandle(), ros::NodeHandle("~")};
    while (ros::ok() && !recorder.complete() && !(asked_to_end && recorder.silence() > silence_s))
      ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(spin_period_s));
    recorder.close();
    while (!recorder.exitAtEnd() && ros::ok() && !asked_to_end)  // the launch decides when to end
      ros::WallDuration(spin_period_s).sleep();
  } catch (const InputError& error) {
    ROS_FATAL("recorder: %s", error.what());
    return 2;
  }
  return 0;
}

}  // namespace amb_rotor
