"""The paper that defines the mechanism: its figures beside the model's, its experiments on the dynamic rig."""
