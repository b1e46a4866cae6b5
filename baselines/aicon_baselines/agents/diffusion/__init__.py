"""Diffusion policies of LeRobot: trained on demonstrations by AICON, and compared.

| file | content |
|---|---|
| `configs.py` | what is recorded, and what is trained |
| `demonstrations.py` | successful episodes of AICON, in pushT some with starts near the goal |
| `corrector.py` | a student that acts first, and AICON, which goes on from where that led |
| `collection.py` | recording demonstrations, and going on with it |
| `dataset.py` | demonstrations as a dataset of LeRobot, and such a dataset in memory |
| `learner.py` | LeRobot's description of the network, and the gradient step |
| `training.py` | training, and going on with it |
| `export.py` | a trained policy as a small folder to pass on |
| `hub.py` | where a saved policy is |
| `checkpoint.py` | loading a policy that was saved here or elsewhere |
| `checkpoint_formats.py` | the formats in which LeRobot has saved them |
| `agent.py` | a saved policy in a comparison |
| `lerobot_names.py` | LeRobot on demand, and what it calls observations and actions |

Recording episodes needs no LeRobot; all else does.
"""
