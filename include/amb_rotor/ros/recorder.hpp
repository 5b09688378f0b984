#pragma once
// Node recorder: writes the topics of a run into a bag at simulated time, without losing a step (rosbag
// record keeps 100 messages a topic while it waits). The bag takes its name when it is whole. doc/nodes.md
#include <ros/ros.h>
#include <rosbag/bag.h>

#include <string>
#include <vector>

namespace amb_rotor {

class Recorder {
 public:
  Recorder(const ros::NodeHandle& nodes, const ros::NodeHandle& own);
  ~Recorder();

  /// Closes the bag and gives it its name; after that nothing is recorded.
  void close();
  bool exitAtEnd() const { return exit_at_end_; }
  /// Whether the run has ended and nothing came for a while.
  bool complete() const;
  /// Seconds of the wall since the last message.
  double silence() const { return (ros::WallTime::now() - last_).toSec(); }

 private:
  template <class Message>
  void record(const std::string& topic);
  template <class Message>
  void write(const std::string& topic, const ros::MessageEvent<Message const>& event);

  ros::NodeHandle nodes_;
  std::string path_, part_;
  bool exit_at_end_;
  rosbag::Bag bag_;
  std::vector<ros::Subscriber> subscribers_;
  ros::WallTime last_;
  ros::Time last_stamp_;
  bool closed_ = false, ended_ = false;
};

/// Runs a recorder until the run has ended, or until SIGINT and silence: what is still on its way is written.
int runRecorder(int argc, char** argv);

}  // namespace amb_rotor
