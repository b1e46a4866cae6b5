"""Diffusion policies of LeRobot: trained on demonstrations by AICON, and compared on pushT.

| file | content |
|---|---|
| `recording_config.py` | what is recorded |
| `demonstrations.py` | successful episodes of AICON; `start_states.py` has starts near the goal |
| `keypoint_observation.py` | pictures and keypoints in one observation |
| `collection.py` | recording demonstrations, and going on with it |
| `dataset_writer.py` | demonstrations as a dataset of LeRobot |
| `dataset.py` | a dataset in memory, with `frames.py` |
| `training_config.py` | what is trained |
| `policy_config.py` | LeRobot's description of the network |
| `learner.py` | the gradient step |
| `training.py` | training, and going on with it; `loss_logger.py` writes the loss |
| `export.py` | a trained policy as a small folder to pass on |
| `hub.py` | where a saved policy is |
| `checkpoint.py` | loading a policy that was saved here or elsewhere |
| `checkpoint_formats.py` | the formats in which LeRobot has saved them |
| `agent.py` | a saved policy in a comparison, with the random numbers of `random_seeds.py` |
| `feature_names.py` | what observations and actions are called in LeRobot |
| `lerobot_import.py` | LeRobot, imported on demand |

Recording episodes needs no LeRobot; all else does.
"""
