//! Which topic serves which stream: as named, or the only one that fits by type and name.

use std::path::Path;

use crate::formats::channel::ParsedChannel;
use crate::formats::container::Channel;
use crate::formats::layout::Layout;
use crate::recording::settings::Streams;
use crate::{error::DatasetError, remark::StreamRole};

/// Words in a topic that speak for a stream; each matches a whole word or a part of four letters.
fn hints(role: StreamRole) -> &'static [&'static str] {
    match role {
        StreamRole::Robot => &[
            "robot", "tip", "tool", "tcp", "pusher", "probe", "ee", "eef", "effector", "finger",
            "gripper", "arm",
        ],
        StreamRole::Object => &[
            "object",
            "obj",
            "vicon",
            "mocap",
            "optitrack",
            "qualisys",
            "block",
            "slider",
            "marker",
            "apriltag",
            "tag",
            "body",
        ],
        StreamRole::Wrench => &["ft", "netft", "force", "wrench", "loadcell"],
    }
}

fn hinted(topic: &str, role: StreamRole) -> bool {
    let topic = topic.to_ascii_lowercase();
    let mut words = topic.split(|c: char| !c.is_ascii_alphabetic());
    words.any(|word| {
        hints(role).iter().any(|hint| word == *hint || (hint.len() >= 4 && word.contains(hint)))
    })
}

/// The topic of each stream; none for a wrench that was not recorded.
pub(crate) fn choose_topics(
    path: &Path,
    channels: &[ParsedChannel<'_>],
    streams: &Streams,
) -> Result<[Option<String>; 3], DatasetError> {
    let mut chosen: [Option<String>; 3] = [None, None, None];
    for role in StreamRole::ALL {
        if let Some(topic) = &streams.of(role).topic {
            if !channels.iter().any(|channel| channel.info.topic == *topic) {
                return Err(DatasetError::TopicMissing {
                    path: path.into(),
                    stream: role,
                    topic: topic.clone(),
                    available: listed(channels.iter().map(|channel| channel.info)),
                });
            }
            chosen[role as usize] = Some(topic.clone());
        }
    }
    for role in StreamRole::ALL {
        if chosen[role as usize].is_none() {
            chosen[role as usize] = choose_one(path, channels, streams, role, &chosen)?;
        }
        if let Some(topic) = &chosen[role as usize] {
            check_one_type(path, channels, streams, role, topic)?;
        }
    }
    Ok(chosen)
}

/// Refuses a topic whose messages are of several types: they are several things.
fn check_one_type(
    path: &Path,
    channels: &[ParsedChannel<'_>],
    streams: &Streams,
    stream: StreamRole,
    topic: &str,
) -> Result<(), DatasetError> {
    let own = channels.iter().filter(|one| one.info.topic == topic && one.info.count > 0);
    let of_one = |channel: &ParsedChannel<'_>| {
        let layout = channel.schema.as_ref().ok();
        let layout = layout.map(|schema| Layout::find(schema, stream, streams.of(stream)));
        // ROS 2 writes `msg/` into the names that ROS 1 has.
        let name = channel.info.type_name.replace("/msg/", "/");
        (name, layout.and_then(Result::ok).map(|layout| layout.has))
    };
    let mut types: Vec<_> = own.map(of_one).collect();
    types.sort();
    types.dedup();
    if types.len() < 2 {
        return Ok(());
    }
    let types = types.into_iter().map(|(name, _)| name).collect::<Vec<_>>().join(" and ");
    Err(DatasetError::TopicTypes { path: path.into(), stream, topic: topic.into(), types })
}

fn choose_one(
    path: &Path,
    channels: &[ParsedChannel<'_>],
    streams: &Streams,
    role: StreamRole,
    taken: &[Option<String>; 3],
) -> Result<Option<String>, DatasetError> {
    let settings = streams.of(role);
    let mut candidates: Vec<&str> = Vec::new();
    for channel in channels {
        let topic = channel.info.topic.as_str();
        let layout = channel.schema.as_ref().ok();
        let layout = layout.and_then(|schema| Layout::find(schema, role, settings).ok());
        let fits = layout.is_some_and(|layout| match &settings.child_frame {
            Some(_) => layout.names_child,
            None => !layout.is_list && !taken.iter().flatten().any(|other| other == topic),
        });
        if fits && channel.info.count > 0 && !candidates.contains(&topic) {
            candidates.push(topic);
        }
    }
    let other = match role {
        StreamRole::Robot => StreamRole::Object,
        StreamRole::Object => StreamRole::Robot,
        StreamRole::Wrench if candidates.is_empty() => return Ok(None),
        StreamRole::Wrench => StreamRole::Wrench,
    };
    // The other pose stream's own topic does not serve this one, even where it is the only one.
    let pose = role != StreamRole::Wrench;
    candidates.retain(|topic| !pose || !hinted(topic, other) || hinted(topic, role));
    if candidates.len() > 1 {
        let speaking = |topic: &&str| hinted(topic, role) && (!pose || !hinted(topic, other));
        let hinted: Vec<&str> = candidates.iter().copied().filter(speaking).collect();
        if !hinted.is_empty() {
            candidates = hinted;
        }
    }
    match candidates.as_slice() {
        [topic] => Ok(Some((*topic).into())),
        _ => Err(DatasetError::TopicChoice {
            path: path.into(),
            stream: role,
            n_candidates: candidates.len(),
            available: listed(channels.iter().map(|channel| channel.info)),
        }),
    }
}

/// Topics with their types, as text for an error.
pub(crate) fn listed<'a>(channels: impl Iterator<Item = &'a Channel>) -> String {
    let mut names: Vec<String> =
        channels.map(|channel| format!("{} ({})", channel.topic, channel.type_name)).collect();
    names.sort();
    names.dedup();
    if names.is_empty() { "nothing: the log has no topics".into() } else { names.join(", ") }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::choose_topics;
    use crate::formats::channel::ParsedChannel;
    use crate::formats::container::Channel;
    use crate::formats::decode::Schema;
    use crate::input::limits::ReadLimits;
    use crate::recording::settings::Streams;
    use crate::{error::DatasetError, remark::StreamRole};

    const POSE: &str = r#"{"pose": {"position": {"x": 0, "y": 0, "z": 0},
                           "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}}"#;
    const WRENCH: &str = r#"{"wrench": {"force": {"x": 0, "y": 0}}}"#;
    const TF: &str = r#"{"transforms": [{"child_frame_id": "tip", "transform": {
        "translation": {"x": 0, "y": 0, "z": 0}, "rotation": {"x": 0, "y": 0, "z": 0, "w": 1}}}]}"#;

    fn choose(topics: &[(&str, &str)], streams: &Streams) -> Result<Vec<String>, DatasetError> {
        let infos: Vec<Channel> = topics
            .iter()
            .map(|&(topic, _)| Channel {
                topic: topic.into(),
                type_name: "T".into(),
                count: 1,
                ..Channel::default()
            })
            .collect();
        let channels: Vec<_> = infos
            .iter()
            .zip(topics)
            .map(|(info, (_, sample))| ParsedChannel {
                info,
                schema: Schema::parse(
                    "",
                    ("json", ""),
                    b"",
                    Some(sample.as_bytes()),
                    &ReadLimits::default(),
                ),
            })
            .collect();
        let chosen = choose_topics(Path::new("log"), &channels, streams)?;
        Ok(chosen.into_iter().map(|topic| topic.unwrap_or_default()).collect())
    }

    #[test]
    fn topics_are_chosen_by_type_and_name() {
        let topics = [("/tip_pose", POSE), ("/vicon/a/a", POSE), ("/ft", WRENCH), ("/tf", TF)];
        assert_eq!(
            choose(&topics, &Streams::default()).unwrap(),
            ["/tip_pose", "/vicon/a/a", "/ft"]
        );
        assert_eq!(choose(&topics[..2], &Streams::default()).unwrap()[2], "");
    }

    #[test]
    fn one_pose_named_leaves_the_other() {
        let mut streams = Streams::default();
        streams.robot.topic = Some("/a".into());
        let chosen = choose(&[("/a", POSE), ("/b", POSE)], &streams).unwrap();
        assert_eq!(chosen[1], "/b");
    }

    #[test]
    fn a_child_frame_makes_a_list_of_transforms_a_candidate() {
        let mut streams = Streams::default();
        streams.robot.child_frame = Some("tip".into());
        let chosen = choose(&[("/tf", TF), ("/vicon/a", POSE)], &streams).unwrap();
        assert_eq!(chosen[..2], ["/tf", "/vicon/a"]);
    }

    #[test]
    fn two_that_fit_are_an_error_that_lists_all() {
        let topics = [("/tip", POSE), ("/vicon", POSE), ("/ft", WRENCH), ("/netft_data", WRENCH)];
        let error = choose(&topics, &Streams::default()).unwrap_err();
        assert!(matches!(
            error,
            DatasetError::TopicChoice { stream: StreamRole::Wrench, n_candidates: 2, .. }
        ));
        assert_eq!(
            error.to_string(),
            "log: 2 topics fit the wrench stream; set streams.wrench.topic to one of: \
             /ft (T), /netft_data (T), /tip (T), /vicon (T)"
        );
        let error = choose(&topics[1..], &Streams::default()).unwrap_err();
        let robot = StreamRole::Robot;
        assert!(
            matches!(error, DatasetError::TopicChoice { stream, n_candidates: 0, .. } if stream == robot)
        );
    }

    #[test]
    fn a_named_topic_that_is_not_there_lists_what_is() {
        let mut streams = Streams::default();
        streams.object.topic = Some("/vicon/hex".into());
        let error = choose(&[("/tip", POSE)], &streams).unwrap_err();
        assert_eq!(
            error.to_string(),
            "log: no `/vicon/hex` for the object stream; set streams.object.topic to one of: \
             /tip (T)"
        );
    }
}
